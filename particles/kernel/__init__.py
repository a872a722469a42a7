"""The compiled loops that follow tracers, the kernels, and what they write down.

One kernel for each kind of run; begin reading with the first one:

- `random_flights`: no scatterers and no field (BoltzmannGrad)
- `among_scatterers`: disks or spheres, no field; steps in `cell_walk` and `pockets`
- `random_parabolas`: no scatterers, in a field along x
- `among_disks`: disks in a field; steps in `falling`, `disk_contact`, `corner` and `sliding`
- `driven`: a bath, noise and drag

What they share: `tracer` (state and start of a tracer), `straight_flight`, `parabolic_flight` with
`parabola`, and `records` (what is kept).
"""
