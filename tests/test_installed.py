"""Versions of packages are those that the library for metadata reads."""

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as in_metadata

import pytest

from camcli.installed import _by_name, version
from camcli.output.run_record import PACKAGES


@pytest.mark.parametrize("package", [*PACKAGES, "llvmlite", "PyYAML", "Python.Flint"])
def test_the_version_of_a_package_is_that_of_its_metadata(package):
    assert version(package) == in_metadata(package)


def test_a_folder_is_enough_and_the_first_on_the_path_counts(tmp_path, monkeypatch):
    for place, number in (("one", "1.5.dev0+local"), ("two", "2.0")):
        (tmp_path / place / f"some_package-{number}.dist-info").mkdir(parents=True)
    places = [str(tmp_path / place) for place in ("nowhere", "one", "two")]
    monkeypatch.setattr("sys.path", places)
    _by_name.cache_clear()
    try:
        assert version("some-package") == "1.5.dev0+local"
        with pytest.raises(PackageNotFoundError):
            version("another-package")
    finally:
        _by_name.cache_clear()
