"""S34: each one-dimensional part exists for translation and for rotation, with the same names."""

from __future__ import annotations

import re
from pathlib import Path

LIBRARY = Path(__file__).parents[3] / "library" / "mechanical"
# Names that differ because the thing itself has another name.
ROTATIONAL = {
    "Mass": "Inertia",
    "Rod": "Disc",
    "Lever": "IdealPlanetary",
    "SupportFriction": "BearingFriction",
    "PartialRodFriction": "PartialShaftFriction",
    "PositionSensor": "AngleSensor",
    "RelPositionSensor": "RelAngleSensor",
    "MassWithStop": "InertiaWithStop",
    "MassWithStopAndFriction": "InertiaWithStopAndFriction",
    "GeneralForceToPositionAdaptor": "GeneralTorqueToAngleAdaptor",
    "GeneralPositionToForceAdaptor": "GeneralAngleToTorqueAdaptor",
    "ForceToPositionAdaptor": "TorqueToAngleAdaptor",
    "PositionToForceAdaptor": "AngleToTorqueAdaptor",
    "TranslationalInerter": "RotationalInerter",
}
# The same class in both packages, declared once.
SHARED = {"IdealGearR2T", "IdealRollingWheel"}
# A vehicle and its wheels' resistance belong to both at once, a Stribeck table fits both; shafts
# have no length, and the base of what turns rotation into translation stands in one place.
ONLY_ONCE = {
    "Vehicle",
    "RollingResistance",
    "GenerateStribeckFrictionTable",
    "PartialRigid",
    "PartialRotationalToTranslational",
}


def classes(package: str) -> dict[str, str]:
    """Return the text of each class of a package by its name."""
    found = {}
    for path in sorted((LIBRARY / package).glob("*.acm")):
        pattern = r"^(?:partial )?(?:model|connector|function) (\w+)(.*?)^end \1;"
        for match in re.finditer(pattern, path.read_text(), re.MULTILINE | re.DOTALL):
            found[match[1]] = match[2]
    return found


def rotational(name: str) -> str:
    """Return the name that a translational class or variable has in rotation."""
    return ROTATIONAL.get(name) or name.replace("Force", "Torque")


def test_the_packages_have_corresponding_parts() -> None:
    translation, rotation = set(classes("translational")), set(classes("rotational"))
    assert len(translation) > 60
    assert {rotational(name) for name in translation - ONLY_ONCE} == rotation - ONLY_ONCE
    assert not ONLY_ONCE - translation - rotation


def test_corresponding_parts_have_corresponding_parameters() -> None:
    translation, rotation = classes("translational"), classes("rotational")
    renamed = {"f_crit": "f_crit", "m": "J", "s": "phi", "v": "w", "f": "tau", "F": "tau"}
    renamed |= {"smin": "phi_min", "smax": "phi_max", "use_v": "use_w"}
    for name in sorted(set(translation) - ONLY_ONCE - SHARED):
        here, there = (
            re.findall(r"^  parameter [\w.]+ (\w+)", text, re.MULTILINE)
            for text in (translation[name], rotation[rotational(name)])
        )
        here = [p for p in here if p not in ("L", "stateSelect")]
        expected = [
            renamed.get(p)
            or re.sub(r"^([svfF])(?=_|0|$)", lambda m: renamed[m[1]], p)
            .replace("_s_", "_phi_")
            .replace("_v_", "_w_")
            .replace("Force", "Torque")
            for p in here
        ]
        there = [p for p in there if p not in ("deltaPhi", "stateSelect")]
        assert expected == there, name
