"""The directive ``outputs``: the table of what a Scene may ask for, from `kinetics.outputs`."""

from docstrings import in_html
from docutils import nodes
from docutils.parsers.rst import Directive


class Outputs(Directive):
    """Name, shape, unit and meaning of every output."""

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        from kinetics.outputs import FIELD_OUTPUTS, OUTPUTS

        heads = "<th>name</th><th>shape or arguments</th><th>unit</th><th>what it is</th>"
        rows = "".join(
            f"<tr><td><code>{row.name}</code></td><td>({', '.join(row.shape)})</td>"
            f"<td>{in_html(row.unit)}</td><td>{in_html(row.description)}</td></tr>"
            for row in (OUTPUTS | FIELD_OUTPUTS).values()
        )
        table = (
            f'<div class="table-wrapper"><table class="docutils"><thead><tr>{heads}</tr></thead>'
            f"<tbody>{rows}</tbody></table></div>"
        )
        return [nodes.raw("", table, format="html")]


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("outputs", Outputs)
    return {"parallel_read_safe": True}
