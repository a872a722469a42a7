"""What drives a tracer: its collisions and what acts on it between them, as one value."""

from dataclasses import dataclass
from math import inf

import numpy as np

from particles.impact import Law, tabulate


@dataclass(frozen=True, kw_only=True)
class Drive:
    """The collisions of a tracer, and what acts on it, in the user's unit of length d and in U.

    Parameters
    ----------
    restitution : e, or how it depends on the impact speed
    tangential_restitution : factor of the velocity across the line of centres
    field : uniform acceleration along x
    mass_ratio : of a scatterer over the tracer; inf for fixed scatterers
    bath_speed : w, standard deviation of a component of the velocity of a scatterer
    heating : D of white noise, <dv_i dv_j> = 2 D delta_ij dt
    drag : gamma in dv/dt = -gamma v
    capture_speed : impacts whose normal speed is below it stick
    """

    restitution: float | Law
    tangential_restitution: float = 1.0
    field: float = 0.0
    mass_ratio: float = inf
    bath_speed: float = 0.0
    heating: float = 0.0
    drag: float = 0.0
    capture_speed: float = 0.0

    @property
    def is_noisy(self) -> bool:
        """Whether there is noise or drag: a path is then not made of flights."""
        return self.heating > 0.0 or self.drag > 0.0

    @property
    def gives_energy(self) -> bool:
        """Whether anything moves a tracer that is at rest."""
        return max(abs(self.field), self.bath_speed, self.heating) > 0.0

    @property
    def depends_on_speed(self) -> bool:
        """Whether what a collision does depends on the impact speed."""
        return isinstance(self.restitution, Law) or self.capture_speed > 0.0

    @property
    def needs_clock(self) -> bool:
        """Whether tracers are followed by `kernel.driven`, in time instead of along their path."""
        in_field = self.field != 0.0 and self.depends_on_speed
        return self.bath_speed > 0.0 or self.is_noisy or in_field

    @property
    def law(self) -> tuple[float, float]:
        """By what a collision multiplies the components of the tracer's velocity, (e, et).

        Along the normal the impulse turns the velocity relative to the scatterer round, times the
        restitution; of the change M/(m + M) is the tracer's, so e may be negative: the tracer then
        follows the scatterer. Where it depends on the speed, e of slow impacts.
        """
        _lowest_octave, values = self.restitution_table()
        return float(values[0]), self.tangential_restitution

    def restitution_table(self) -> tuple[int, np.ndarray]:
        """Return e over the impact speed as `impact.tabulate`, with the share of the tracer."""
        lowest_octave, values = tabulate(self.restitution)
        if self.mass_ratio < inf:
            reduced_mass = self.mass_ratio / (1.0 + self.mass_ratio)
            values = (1.0 + values) * reduced_mass - 1.0
        return lowest_octave, values
