"""The index of the search holds words that somebody looks for, and nothing else."""

from __future__ import annotations

import json

from website.search_index import shrink

KEPT = {
    "location": "reference/maps.html#jaxwalk.maps.load_map",
    "title": "load_map  <small><code>function</code></small>",
    "text": "Return a map.  It takes 3.25 s, in 99 % of <em>cases</em>. Parameters: Name Type x Raises: Type MapError",
}
LEFT_OUT = {"location": "changelog.html#new", "title": "New", "text": "A door."}


def test_names_and_sentences_stay(tmp_path):
    (tmp_path / "search.json").write_text(json.dumps({"config": {}, "items": [KEPT, LEFT_OUT]}), encoding="utf-8")

    shrink(tmp_path)

    [item] = json.loads((tmp_path / "search.json").read_text(encoding="utf-8"))["items"]
    assert item["title"] == "load_map"
    assert item["text"].strip() == "Return a map. It takes s, in of cases Raises: Type MapError"
    assert (tmp_path / "search.js").read_text(encoding="utf-8").startswith('var __index = {"config":')
