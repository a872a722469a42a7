"""The version of the installed package."""

from importlib import metadata

#: What is reported where the package is not installed, as in a source folder on the path.
UNKNOWN_VERSION = "0+unknown"


def package_version() -> str:
    """Return the version of the installed distribution."""
    try:
        return metadata.version("inelastic-lorentz")
    except metadata.PackageNotFoundError:
        return UNKNOWN_VERSION
