"""The version of this package, as results and `lorentz --version` say it."""

from importlib.metadata import PackageNotFoundError, version


def package_version() -> str:
    """The version that is installed; "0+unknown" where the package is not."""
    try:
        return version("inelastic-lorentz")
    except PackageNotFoundError:
        return "0+unknown"
