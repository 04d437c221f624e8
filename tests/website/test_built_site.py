"""The check of built pages finds what is wrong."""

from __future__ import annotations

from website.built_site import faults, home_size

HEAD = "<html><head><link rel='stylesheet' href='a.css'></head><body><h1 id='top'>x</h1>"


def test_faults_are_found(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "a.css").write_text("p { color: red }")
    (tmp_path / "index.html").write_text(
        f"{HEAD}<a href='deep/b.html#there'>1</a><a href='#top'>2</a><a href='https://example.org'>3</a>"
        "<a href='none.html'>4</a><a href='deep/b.html#nowhere'>5</a><a href='../outside.html'>6</a>"
        "<img src='none.png'><script src='https://example.org/x.js'></script></body></html>"
    )
    (tmp_path / "deep" / "b.html").write_text("<p id='there'>x</p><a href='../index.html'>1</a>")
    (tmp_path / "b.css").write_text("@import url('https://example.org/x.css');")
    (tmp_path / "c.js").write_text("fetch('//example.org/x')")
    found = faults(tmp_path)
    assert [fault.split(": ", 1)[1].split(",")[0] for fault in found if fault.startswith("index.html")] == [
        "loads none.png", "loads https://example.org/x.js", "links to none.html", "links to deep/b.html#nowhere",
        "links to ../outside.html",
    ]  # fmt: skip
    assert [fault.split(":")[0] for fault in found if not fault.startswith("index.html")] == ["b.css", "c.js"]


def test_the_home_page_is_weighed_compressed(tmp_path):
    (tmp_path / "a.css").write_text("p { color: red }\n" * 10_000)
    (tmp_path / "index.html").write_text(HEAD)
    assert 100 < home_size(tmp_path) < 2000
