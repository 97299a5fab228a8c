import os

import pytest

from handlab.simulation.writing import whole_file, write_text


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_text("old")
    with pytest.raises(RuntimeError, match="half way"), whole_file(path) as part:
        part.write_text("half")
        raise RuntimeError("half way")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_temporary_file_has_the_suffix_of_the_real_one(tmp_path):
    with whole_file(tmp_path / "film.mp4") as part:
        assert part.suffix == ".mp4" and part.parent == tmp_path
        part.write_text("new")
    assert (tmp_path / "film.mp4").read_text() == "new"


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"cannot write .*film\.csv: the folder .*missing does not exist"):
        write_text(tmp_path / "missing" / "film.csv", "x")


def test_a_folder_is_no_place_for_a_file(tmp_path):
    with pytest.raises(IsADirectoryError, match="it is a folder"):
        write_text(tmp_path, "x")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_is_locked_is_named(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(PermissionError, match="cannot write"):
            write_text(tmp_path / "x.csv", "x")
    finally:
        tmp_path.chmod(0o700)


def test_a_write_that_the_system_refuses_is_named(tmp_path, monkeypatch):
    def refuse(*_args, **_kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.touch", refuse)
    with pytest.raises(PermissionError, match=r"cannot write .*x\.csv: Permission denied"):
        write_text(tmp_path / "x.csv", "x")
    assert list(tmp_path.iterdir()) == []
