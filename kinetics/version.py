"""The version of this package, as results and `lorentz --version` say it."""

from importlib import metadata


def package_version() -> str:
    """The version that is installed; "0+unknown" where the package is not."""
    try:
        return metadata.version("inelastic-lorentz")
    except metadata.PackageNotFoundError:
        return "0+unknown"
