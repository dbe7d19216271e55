"""Critical length of the propagation saw test by the package weac: how long the cut is when the weak layer yields at its tip.

weac (PyPI; Weissgraeber & Rosendahl 2023, The Cryosphere 17, 1475-1496) computes a slab on an elastic layer. Parameters are those of the
sheet (snow-mpm A5). The column is cut from its lower end and long enough for the upper one not to matter.

    pip install weac==2.6.4
    python weac.py > weac.csv
"""

import math

import weac
from scipy.optimize import brentq

DENSITY, YOUNG, POISSON, THICKNESS = 250.0, 3.0, 0.3, 400.0  # slab: kg/m3, MPa, -, mm
WEAK_YOUNG, WEAK_POISSON, WEAK_THICKNESS = 1.0, 0.3, 100.0  # weak layer: MPa, -, mm
SLOPE_OF_ELLIPSE, COHESION = 1.2, 0.3  # M and beta of the weak layer
LENGTH = 20e3  # mm


def column():
    """weac holds the slab by E/(1 - nu^2)/t across the layer and G/t along it. Its E and nu are such that these are the oedometric
    modulus and the shear modulus of the weak layer over its thickness; the modulus of its slab, a power of density, is ours."""
    exponent = 4.4
    factor = YOUNG / 1e3 / (DENSITY / 916.7) ** exponent
    shear = WEAK_YOUNG / 2 / (1 + WEAK_POISSON)
    poisson = 1 - (1 - 2 * WEAK_POISSON) / (1 - WEAK_POISSON)
    test = weac.Layered(system="-pst", touchdown=False)
    test.set_beam_properties([[DENSITY, THICKNESS]], C0=factor, C1=exponent, nu=POISSON)
    test.set_foundation_properties(t=WEAK_THICKNESS, E=2 * shear * (1 + poisson), nu=poisson, update=True)
    return test


def at_tip(test, slope, cut):
    """Normal and shear stress of the layer (kPa) at the tip of a cut (mm)."""
    segments = test.calc_segments(L=LENGTH, a=cut, phi=slope)["crack"]
    solution = test.assemble_and_solve(phi=slope, **segments)
    places, fields, _ = test.rasterize_solution(C=solution, phi=slope, **segments)
    tip = next(number for number, place in enumerate(places) if place >= cut - 1e-3)
    return test.sig(fields, unit="kPa")[tip], test.tau(fields, unit="kPa")[tip]


def beyond(normal, shear, strength):
    """The ellipse of cohesive Cam clay at a stress that strains along the normal alone; positive beyond it."""
    across = WEAK_POISSON / (1 - WEAK_POISSON) * normal
    pressure = (normal + 2 * across) / 3
    deviator = math.sqrt((normal - across) ** 2 + 3 * shear**2)
    ellipse = SLOPE_OF_ELLIPSE**2 * (pressure + COHESION * strength) * (pressure - strength)
    return deviator**2 * (1 + 2 * COHESION) + ellipse


def critical(slope, strength):
    def excess(cut):
        normal, shear = at_tip(test, slope, cut)
        return beyond(abs(normal), shear, strength)

    test = column()
    return brentq(excess, 5.0, 1500.0, xtol=1e-2) / 1e3


print("# Critical lengths of the propagation saw test by the package weac 2.6.4 (Weissgraeber & Rosendahl 2023, The Cryosphere 17, 1475-1496),")
print("# as weac.py computes them for slab and weak layer of sheet: snow-mpm A5")
print("slope (degrees),strength (Pa),critical length (m)")
for slope, strength in [(0, 2), (0, 3), (0, 4), (0, 6), (15, 3), (30, 3), (40, 5)]:
    print(f"{slope},{1000 * strength},{critical(slope, strength):.4f}")
