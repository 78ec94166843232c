"""Signed files, made once for all tests of a process."""

import pytest

from tests.station.results.certificate.signing.signed_files import signed_files


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, bytes]:
    return signed_files(tmp_path_factory.mktemp("time"))
