"""OpenDRIVE files before netconvert reads them. What it makes of them is tested in test_eclipse_sumo.py."""

import os
import sys
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from jaxwalk.maps.imported import opendrive_source
from jaxwalk.maps.imported.importing import read_source
from jaxwalk.maps.imported.opendrive_file import opendrive_file
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from maps.imported.drive_files import LOCAL, ON_ROAD, crosswalk, drive_file
from maps.imported.sumo_nets import road_net
from maps.imported.written_maps import written_as


def written(folder, text):
    return written_as(folder, text, "road.xodr")


@pytest.mark.parametrize(
    "thing, s, t, length",
    [
        (crosswalk(120), 120, 0, 7),
        (crosswalk(120, size="", t=-1.0, outline=LOCAL), 120, 0, 7),
        (crosswalk(120, size="", outline=ON_ROAD), 200, 0, 4),
    ],
    ids=["length and width", "outline of its own", "outline on the road"],
)
def test_a_crosswalk_has_a_place_and_a_size(tmp_path, thing, s, t, length):
    file = opendrive_file(written(tmp_path, drive_file(thing)))
    (found,) = fromstring(file.text).iter("object")
    numbers = {name: float(found.get(name)) for name in ("s", "t", "length", "width")}
    assert numbers == pytest.approx({"s": s, "t": t, "length": length, "width": 11 - length}, abs=1e-9)
    assert file.crosswalks == {found.get("id"): "crosswalk 9 of road 1"} and not list(found)


def test_only_crosswalks_are_read_whatever_their_ids(tmp_path):
    others = crosswalk(10, kind="pole") + crosswalk(20, kind="-1", name="Stencil_STOP") + crosswalk(30, kind="none")
    known = crosswalk(40) + crosswalk(50, kind="-1", name="ContinentalCrosswalk")
    file = opendrive_file(written(tmp_path, drive_file(others + known)))
    assert list(file.crosswalks.values()) == ["crosswalk 9 of road 1", "crosswalk 9 of road 1 (2)"]
    assert [x.get("s") for x in fromstring(file.text).iter("object")] == ["40", "50"]
    assert b"geoReference" not in file.text, "else netconvert writes degrees"


def test_names_may_have_a_space_of_their_own(tmp_path):
    text = drive_file(crosswalk(40)).replace("<OpenDRIVE>", '<OpenDRIVE xmlns="http://code.asam.net/opendrive">')
    assert len(opendrive_file(written(tmp_path, text)).crosswalks) == 1


WHOLE = drive_file(crosswalk(40))
BAD = {
    "cut off": (WHOLE[: len(WHOLE) // 2], "not XML that can be read"),
    "nothing": ("", "not XML that can be read"),
    "a document type": (WHOLE.replace("<OpenDRIVE>", "<!DOCTYPE a><OpenDRIVE>"), "declares a document type"),
    "another root": (drive_file("", root="net"), "begins with <net>, not with <OpenDRIVE>"),
    "left": (drive_file("", rule="LHT"), "traffic keeps left on road 1"),
    "a word for a number": (drive_file(crosswalk(40, size='length="long"')), "a crosswalk isn't as the format has it"),
    "no place": (drive_file(crosswalk("nan", size="", outline=LOCAL)), "s of <object>: nan"),
}  # fmt: skip


@pytest.mark.parametrize("text, message", BAD.values(), ids=BAD)
def test_a_bad_file_ends_in_one_message(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(ImportRefusal) as refusal:
        opendrive_file(path)
    said = str(refusal.value)
    assert message in said and said.startswith(str(path)) and "\n" not in said and ";" in said


def test_a_part_of_the_earth_and_a_missing_program_are_refused(tmp_path, monkeypatch):
    path = written(tmp_path, WHOLE)
    with pytest.raises(ImportRefusal, match="OpenDRIVE files are read whole; leave --centre and --bbox out"):
        read_source(path, Region.around(60.17, 24.94, 100.0))
    monkeypatch.setattr(opendrive_source, "find_spec", lambda _: None)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ImportRefusal, match=r'needs SUMO\'s program netconvert; .*pip install "jaxwalk\[opendrive\]"'):
        read_source(path)
    monkeypatch.setitem(sys.modules, "sumolib", None)
    with pytest.raises(ImportRefusal, match=r'needs sumolib; install it by: pip install "jaxwalk\[opendrive\]"'):
        read_source(path)


def test_what_netconvert_says_is_named(tmp_path, monkeypatch):
    """A program that can't run, fails, writes nothing, or doesn't end."""
    path = written(tmp_path, WHOLE)
    program = tmp_path / "netconvert"
    monkeypatch.setattr(opendrive_source, "netconvert", lambda _: str(program))
    monkeypatch.setattr(opendrive_source, "LONGEST", 0.5)
    with pytest.raises(ImportRefusal, match="netconvert can't be started"):
        read_source(path)
    for script, message in (
        ("echo 'Error: no roads in it.' >&2; exit 1", r"can't make a network of it \(Error: no roads in it\.\)"),
        ("exit 0", r"can't make a network of it \(exit code 0\)"),
        ("exec sleep 30", "took longer than 0.5 s"),
    ):
        program.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        program.chmod(0o700)
        with pytest.raises(ImportRefusal, match=message):
            read_source(path)


def test_a_file_of_too_many_bytes_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("jaxwalk.maps.imported.opendrive_file.MOST_BYTES", 100)
    with pytest.raises(ImportRefusal, match=r"road\.xodr: larger than 100 bytes; cut a part out"):
        opendrive_file(written(tmp_path, WHOLE))


@pytest.fixture
def converted(tmp_path, monkeypatch):
    """Reads a file of crosswalks by a netconvert on the path that writes a given network and given outlines."""
    program = tmp_path / "netconvert"
    copy = '--output-file) cp made.net.xml "$2";; --polygon-output) cp shapes.xml "$2";;'.replace(
        "cp ", f"cp {tmp_path}/"
    )
    program.write_text(f'#!/bin/sh\nwhile [ $# -gt 0 ]; do case "$1" in {copy} esac; shift; done\n', encoding="utf-8")
    program.chmod(0o700)
    monkeypatch.setattr(opendrive_source, "find_spec", lambda _: None)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")

    def read(net, *outlines):
        path = written(tmp_path, drive_file(crosswalk(120) * len(outlines)))
        numbers = opendrive_file(path).crosswalks
        shapes = [f'<poly id="{n}" shape="{x}"/>' for n, x in zip(numbers, outlines, strict=True) if x]
        written_as(tmp_path, net, "made.net.xml")
        written_as(tmp_path, f"<additional>{''.join(shapes)}</additional>", "shapes.xml")
        return read_source(path)

    return read


OUTLINE = "118,46.5 122,46.5 122,53.5,0.2 118,53.5"
"""A rectangle over the road of 7 m, which runs along y = 50; a corner may have a height."""


@pytest.mark.parametrize(
    "lights, kind", [("priority", ("zebra", "mapped")), ("traffic_light", ("signals", "inferred"))]
)
def test_crosswalks_lie_where_netconvert_places_them(converted, lights, kind):
    source = converted(road_net().replace('type="priority"', f'type="{lights}"'), OUTLINE)
    (found,) = source.crossings
    assert (found.name, found.kind, found.kind_origin, found.width) == ("crosswalk 9 of road 1", *kind, 4.0)
    np.testing.assert_allclose(found.point, (120, 50))
    np.testing.assert_allclose(np.abs(found.across), (0, 1))
    assert source.attribution == "OpenDRIVE file road.xodr, which names no author" and source.left_out == ()


def test_crosswalks_without_an_outline_are_counted(converted):
    source = converted(road_net(), OUTLINE, "", "118,46.5 122,46.5")
    assert [x.name for x in source.crossings] == ["crosswalk 9 of road 1"]
    assert source.left_out == ("2 crosswalks that netconvert doesn't place",)
