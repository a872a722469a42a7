"""Makes the page of `lorentz explore`, which stands beside the others as explorer.html."""

from pathlib import Path


def _make(app, config) -> None:
    from kinetics.crosscheck import explore

    folder = Path(app.srcdir) / "generated"
    folder.mkdir(exist_ok=True)
    text = explore.render(explore.all_tables())
    (folder / "explorer.html").write_text(text, encoding="utf-8")


def setup(app) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("config-inited", _make)
    return {"parallel_read_safe": True}
