"""``jaxwalk bench`` on the command line: one document, or a table."""

from __future__ import annotations

import json

import pytest

from jaxwalk.cli import main


@pytest.mark.long
def test_bench_prints_one_document_and_keeps_it(place, capfd):
    command = "bench --only env --environments 8 --seconds 0.05 --json --out bench"
    assert main(command.split()) == 0
    out, err = capfd.readouterr()
    document = json.loads(out)
    assert (place / "bench" / "bench.json").read_text() == out
    assert document["figures"]["env_steps_per_s"]["value"] == document["rows"]["env"][0]["env_steps_per_s"] > 0
    assert document["hardware"].keys() >= {"processor", "cores", "memory_bytes", "accelerator"}
    assert document["provenance"]["versions"].keys() >= {"jax", "jaxlib", "python"}
    assert f"{document['hardware']['devices']} devices of JAX" in err


def test_bench_prints_a_table(capfd, monkeypatch):
    from jaxwalk.bench import document

    monkeypatch.setattr(document, "starts", lambda: {"import_s": 0.25, "help_s": 0.5})
    assert main(["bench", "--only", "compile"]) == 0
    out = capfd.readouterr().out
    assert "import_s" in out
    assert "0.25 s" in out
