"""Files of kept scenarios that can't be used are refused in words."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from safetensors.numpy import save_file

from jaxwalk.maps import MapError, MapText
from jaxwalk.scenarios.archive_file import HEADER, ArchiveError, read_archive, read_tensors
from scenarios.small_archive import COUNT, write_small_archive


def test_a_file_that_isn_t_there_is_named(tmp_path):
    with pytest.raises(ArchiveError, match=r"none\.safetensors: no such file; check the name"):
        read_tensors(tmp_path / "none.safetensors", HEADER, "file of scenarios")


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"present": np.ones((COUNT, 5), bool)}, rf"present must be of shape \({COUNT}, 12\) and keys of \({COUNT},\)"),
        ({"keys": np.arange(COUNT + 1)}, rf"present must be of shape \({COUNT}, 12\) and keys of \({COUNT},\)"),
        ({"seed": 2**31}, r"seed and keys must lie in \[0, 2\^31\)"),
    ],
    ids=["people", "keys", "seed"],
)
def test_arrays_must_fit_each_other(street, tmp_path, changed, message):
    kept = write_small_archive(tmp_path / "kept.safetensors", street)
    with pytest.raises(ValueError, match=message):
        replace(kept, **changed)


def test_a_map_with_faults_is_named_by_its_own_message(street, tmp_path):
    """As after somebody changed the map in the file: what is wrong is the map's, not the file's."""
    file = tmp_path / "kept.safetensors"
    write_small_archive(file, street)
    text, arrays = read_tensors(file, HEADER, "file of scenarios")
    wrong = MapText.of("mine.toml", "size = 3")
    header = json.loads(text) | {"maps": [{"name": wrong.name, "hash": wrong.hash, "text": wrong.text}]}
    save_file(arrays, file, {HEADER: json.dumps(header)})
    with pytest.raises(MapError, match=r"map mine\.toml has 7 faults"):
        read_archive(file)
