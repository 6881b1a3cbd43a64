"""Laws of the oil film between pin and bush: force, moments and loss from where the pin is and how it moves.

The film sees one vector.  With e = pin centre minus bush centre, the rates w_A of the bush and w_B of the pin,

    v = e' - w_m z x e        w_m = (w_A + w_B)/2                                                 [m/s]

is the velocity of the pin's centre in a frame that turns with the mean of both; Reynolds' equation for the gap
h = c - e.u has the right side -v.u.  The force on the pin is F, that on the bush -F at the pin's centre; moments about
the own centre of each follow from the shear of the film and from the balance of moments on it,

    T_c = mu (R^3 L/c) (w_B - w_A) arc        T_A = T_c - X/2        T_B = -T_c - X/2        X = (e x F)_z

with arc = int dphi/H = 2 pi/s over the whole circumference, or 2 Q/s over the part with pressure, s^2 = 1 - (|e|/c)^2.
The loss is -F.e' - T_A w_A - T_B w_B = -F.v + T_c (w_B - w_A) [W]; it is not negative where -F.v is not.

From a least thickness on the coefficients are those of that thickness, also beyond the bush: a trial state of a stepper
gets a finite force, which still resists.

The kernel is  f(ex, ey, vx, vy, w_A, w_B, p, k, table, out), out = F_x, F_y [N], T_A, T_B [N*m], loss [W];
p[k:] comes from `pack`, table from `table` (several films may share one: p[k + START] is where the own part begins).
"""

from __future__ import annotations

from rattle.interfaces.fields import Field, LawValues
from rattle.language.recorded import as_number


def ratio_of(values: LawValues) -> float:
    """L/D [-] of the fields of a film."""
    return 0.5 * as_number(values["length"]) / as_number(values["bush_radius"])


CAVITATION = Field(
    "",
    "reynolds: no pressure below that of the surroundings; full: of either sign, as in a submerged or pressurised film",
    "reynolds",
    "choice",
    choices=("reynolds", "full"),
)
