"""What answers are: values, and the datasets, data frames, plots and files that are made of them.

Modules, each of which imports only those before it:

- `table`: small tables for notebooks, and numbers with the digits that their error has
- `value`: frozen dataclasses that are compared and hashed by their contents
- `record`: a value as JSON, and back
- `frame`: datasets of xarray and data frames of pandas
- `labels`: labels and titles of figures
- `plot`: curves of a quantity with matplotlib
- `file`: netCDF files that are written whole or not at all
- `result`: the base classes `Storable` (it can be saved) and `Result` (and plotted): begin here

xarray, pandas, h5py and matplotlib are imported at first use. Imports nothing of the package but
`kinetics.errors` and `kinetics.version`.
"""
