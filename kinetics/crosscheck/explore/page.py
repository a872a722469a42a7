"""The page: its tables, its script and its style in one HTML file."""

import json
from typing import Any

from kinetics import __version__
from kinetics.crosscheck.explore import tables
from kinetics.crosscheck.files import plain

TRACERS = 200


def render(made: tables.Tables) -> str:
    """The page of these tables, which needs nothing beside it."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    speeds, weights = tables.starts()
    data: dict[str, Any] = {
        "tables": {name: table.as_json() for name, table in made.items()},
        "speeds": speeds, "weights": weights, "widths": tables.WIDTHS,
        "densities": tables.DENSITIES, "highestDriven": tables.HIGHEST_DRIVEN,
        "powers": tables.POWERS, "unit": tables.UNIT,
    }  # fmt: skip
    environment = Environment(
        loader=PackageLoader("kinetics.crosscheck"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template("explorer.html.j2").render(
        data=Markup(json.dumps(plain(data), allow_nan=False, separators=(",", ":"))),
        version=__version__, tracers=TRACERS, densities=tables.DENSITIES,
    )  # fmt: skip
