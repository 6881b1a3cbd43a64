"""A file of a result gives the numbers that were saved, or a ValueError: whatever happened to it, whoever made it."""

import base64
import io
import json
import pickle
import shutil
import sys
import tracemalloc
import zipfile

import h5py
import numpy as np
import pytest

import rattle as rt
from circling import circling
from rattle.results import archive
from rattle.results.columns import geometry
from rattle.results.record_schema import BodyForm, Geometry, JointForm, LoadForm, misfit
from rattle.results.result import load_result

pytestmark = pytest.mark.nojit
SUFFIXES = ("nc", "npz")


def saved(folder, suffix, n=21):
    r = circling(n)
    r.save(folder / f"r.{suffix}")
    return r, (folder / f"r.{suffix}").read_bytes()


def same(one, other):
    return one.stored == other.stored and all(
        np.array_equal(one[name], other[name]) and one.unit(name) == other.unit(name) for name in one.stored
    )


def record():
    made = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(archive, "write", lambda path, given, t, data: made.update(given))
        circling(5).save("r.npz")
    return json.loads(json.dumps(made, default=archive._plain))


# ---------------------------------------------------------------- damage
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_damaged_files_are_refused_or_give_the_same_numbers(tmp_path, suffix):
    r, whole = saved(tmp_path, suffix)
    file = tmp_path / f"d.{suffix}"
    rng = np.random.default_rng(7)
    refused = 0
    for case in range(300):
        content = bytearray(whole)
        if case % 3 == 2:
            del content[int(rng.integers(len(content))) :]
        for _ in range(int(rng.integers(1, 4)) if case % 3 else 1):
            if content:
                content[int(rng.integers(len(content)))] = int(rng.integers(256))
        file.write_bytes(content)
        try:
            assert same(load_result(file), r)
        except ValueError:
            refused += 1
    assert refused > 200


def test_a_netcdf_file_with_a_changed_byte_never_reaches_the_hdf5_library(tmp_path, monkeypatch):
    _, whole = saved(tmp_path, "nc")
    monkeypatch.setattr(h5py, "File", None)
    content = bytearray(whole)
    content[len(content) // 2] ^= 1
    (tmp_path / "d.nc").write_bytes(content)
    with pytest.raises(ValueError, match="is damaged: its bytes do not match its checksum"):
        load_result(tmp_path / "d.nc")


def test_numbers_changed_by_another_program_are_noticed(tmp_path):
    saved(tmp_path, "nc")
    content = (tmp_path / "r.nc").read_bytes()
    (tmp_path / "r.nc").write_bytes(content[: content.rindex(archive.TRAILER)])
    with h5py.File(tmp_path / "r.nc", "r+") as file:
        file["O.normal"][3] = 0.0
    with pytest.raises(ValueError, match="is damaged: its content does not match its checksum"):
        load_result(tmp_path / "r.nc")


def test_a_copy_made_by_xarray_is_read(tmp_path):
    import xarray

    r, _ = saved(tmp_path, "nc")
    with xarray.open_dataset(tmp_path / "r.nc") as dataset:
        dataset.to_netcdf(tmp_path / "copy.nc", engine="h5netcdf")
    assert same(load_result(tmp_path / "copy.nc"), r)


def test_scale_factors_do_not_change_the_numbers(tmp_path):
    r, content = saved(tmp_path, "nc")
    (tmp_path / "r.nc").write_bytes(content[: content.rindex(archive.TRAILER)])
    with h5py.File(tmp_path / "r.nc", "r+") as file:
        file["O.normal"].attrs.update(scale_factor=2.0, add_offset=1.0, _FillValue=r["O.normal"][0])
    assert same(load_result(tmp_path / "r.nc"), r)


# ---------------------------------------------------------------- files made to harm
def leads_elsewhere(file, other):
    del file["lift"]
    file["lift"] = h5py.ExternalLink(str(other), "lift")


def lies_elsewhere(file, other):
    del file["lift"]
    file.create_dataset("lift", (21,), "<f8", external=[(str(other), 0, 168)])


def made_of_others(file, other):
    del file["lift"]
    layout = h5py.VirtualLayout((21,), "<f8")
    layout[:] = h5py.VirtualSource(str(other), "lift", (21,))
    file.create_virtual_dataset("lift", layout)


def soft_link(file, other):
    del file["lift"]
    file["lift"] = h5py.SoftLink("/O.normal")


def empty_but_endless(file, other):
    for name in list(file):
        if name != archive.RECORD:
            del file[name]
            file.create_dataset(name, (10**12,), "<f8", chunks=(1000,))


def no_numbers(file, other):
    del file["lift"]
    file["lift"] = np.array(["x"] * 21, dtype="S1")


def a_group(file, other):
    del file["t"]
    file.create_group("t")


def no_text(file, other):
    del file[archive.RECORD]
    file[archive.RECORD] = 5


def twice_the_same(file, other):
    del file["lift"]
    file["lift"] = file["O.normal"]


HARM = [
    twice_the_same,
    leads_elsewhere,
    lies_elsewhere,
    made_of_others,
    soft_link,
    empty_but_endless,
    no_numbers,
    a_group,
    no_text,
]


@pytest.mark.parametrize("harm", HARM)
def test_netcdf_files_that_lead_elsewhere_or_lie_about_their_size_are_refused(tmp_path, harm):
    _, content = saved(tmp_path, "nc")
    shutil.copy(tmp_path / "r.nc", tmp_path / "other.nc")
    (tmp_path / "r.nc").write_bytes(content[: content.rindex(archive.TRAILER)])
    with h5py.File(tmp_path / "r.nc", "r+") as file:
        harm(file, tmp_path / "other.nc")
    with pytest.raises(ValueError, match=r"r\.nc "):
        load_result(tmp_path / "r.nc")


@pytest.mark.parametrize("own", [True, False])
def test_only_copies_made_by_other_programs_may_be_packed(tmp_path, own):
    """They are, if one asks for it; a file that says that rattle itself wrote it is not."""
    r, content = saved(tmp_path, "nc")
    content = content[: content.rindex(archive.TRAILER)]
    (tmp_path / "r.nc").write_bytes(content)
    with h5py.File(tmp_path / "r.nc", "r+") as file:
        del file["lift"]
        file.create_dataset("lift", data=r["lift"], compression="gzip")
        file["lift"].attrs["units"] = r.unit("lift")
    if own:
        (tmp_path / "r.nc").write_bytes(archive.sealed((tmp_path / "r.nc").read_bytes()))
        with pytest.raises(ValueError, match="holds 'lift' packed"):
            load_result(tmp_path / "r.nc")
    else:
        assert same(load_result(tmp_path / "r.nc"), r)


def test_a_file_of_rattle_that_declares_more_than_it_holds_is_refused(tmp_path):
    """Values that were never written take no place in the file."""
    _, content = saved(tmp_path, "nc")
    (tmp_path / "r.nc").write_bytes(content[: content.rindex(archive.TRAILER)])
    with h5py.File(tmp_path / "r.nc", "r+") as file:
        for name in list(file):
            if name != archive.RECORD:
                del file[name]
                file.create_dataset(name, (100_000,), "<f8", chunks=(1000,))
    (tmp_path / "r.nc").write_bytes(archive.sealed((tmp_path / "r.nc").read_bytes()))
    with pytest.raises(ValueError, match="more than"):
        load_result(tmp_path / "r.nc")


def header_of(shape, dtype="<f8"):
    import io

    out = io.BytesIO()
    np.lib.format.write_array_header_1_0(out, {"descr": dtype, "fortran_order": False, "shape": shape})
    return out.getvalue()


def pickled():
    import io

    out = io.BytesIO()
    np.save(out, np.array([print], dtype=object), allow_pickle=True)
    return out.getvalue()


@pytest.mark.parametrize("lift", [header_of((10**12,)), pickled(), b"", b"\x93NUMPY\x09\x00", header_of((21,), "<U1")])
def test_arrays_in_an_npz_that_are_none_are_refused(tmp_path, lift):
    saved(tmp_path, "npz")
    with zipfile.ZipFile(tmp_path / "r.npz") as old, zipfile.ZipFile(tmp_path / "h.npz", "w") as new:
        for name in old.namelist():
            new.writestr(name, lift if name == "lift.npy" else old.read(name))
    with pytest.raises(ValueError, match="not a result of rattle"):
        load_result(tmp_path / "h.npz")


@pytest.mark.parametrize("way", [zipfile.ZIP_BZIP2, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA])
def test_a_packed_file_that_would_fill_the_memory_is_refused(tmp_path, way):
    saved(tmp_path, "npz")
    with zipfile.ZipFile(tmp_path / "r.npz") as old, zipfile.ZipFile(tmp_path / "h.npz", "w") as new:
        for name in old.namelist():
            if name not in ("t.npy", "lift.npy"):
                new.writestr(name, old.read(name))
        for name in ("t", "lift"):
            zeros = header_of((2_000_000,)) + bytes(16_000_000)
            new.writestr(f"{name}.npy", zeros, way)  # one byte for thousands
    with pytest.raises(ValueError, match=r"h\.npz holds 't' packed"):
        load_result(tmp_path / "h.npz")


def test_a_packed_record_is_refused_before_memory_is_taken_for_it(tmp_path):
    """Of 200 MB in 0.2 MB, as they would be unpacked, nothing is."""
    saved(tmp_path, "npz")
    with zipfile.ZipFile(tmp_path / "r.npz") as old, zipfile.ZipFile(tmp_path / "h.npz", "w") as new:
        for name in old.namelist():
            if name != f"{archive.RECORD}.npy":
                new.writestr(name, old.read(name))
        words = io.BytesIO()
        np.lib.format.write_array(words, np.array(b"{}" + bytes(200_000_000)), allow_pickle=False)
        new.writestr(f"{archive.RECORD}.npy", words.getvalue(), zipfile.ZIP_DEFLATED)
    del words
    tracemalloc.start()
    try:
        with pytest.raises(rt.InputError, match="packed"):
            load_result(tmp_path / "h.npz")
        assert tracemalloc.get_traced_memory()[1] < 5e6
    finally:
        tracemalloc.stop()


def test_members_of_an_npz_that_share_their_bytes_are_refused(tmp_path):
    """Curves that are one inside of the other make many of few bytes, without any packing."""
    r = circling(2001)
    r.save(tmp_path / "r.npz")
    content = (tmp_path / "r.npz").read_bytes()
    with zipfile.ZipFile(tmp_path / "r.npz") as old:
        size = sum(one.file_size for one in old.infolist())
    assert size <= len(content)
    with pytest.raises(archive.Damaged, match="more than"):
        archive._fits(len(r.stored) + 50, 2001, len(content), packed=1)


def test_every_example_has_the_geometry_that_files_are_compared_with():
    """No key is written that the types do not know, but for dimensions of a play."""
    for name in rt.examples():
        drawn = json.loads(json.dumps(geometry(rt.example(name).model)))
        assert misfit(drawn, Geometry, "geometry") == "", name
        for family, form in (("joints", JointForm), ("loads", LoadForm), ("bodies", BodyForm)):
            for one in drawn[family].values():
                more = one.keys() - form.__annotations__.keys()
                assert all(not misfit(one[key], list[float], key) for key in more), (name, family, more)


def without(key):
    return lambda given: given.pop(key)


def put(**more):
    return lambda given: given.update(more)


def in_joint(**more):
    def change(given):
        form = {
            "type": "revolute",
            "bodies": ["arm", "ground"],
            "points": [[0, 0], [0, 0]],
            "clearance": 0.0,
            "contact": "",
        }
        given["geometry"] = {"bodies": {"arm": {"points": {}}}, "joints": {"O": {**form, **more}}}

    return change


def in_trust(**more):
    return lambda given: given["trust"].update(more)


def in_provenance(**more):
    return lambda given: given["provenance"].update(more)


def film_without_oil(given):
    name = given["names"][0]
    given["names"][0] = "O.film_thickness"
    given["units"]["O.film_thickness"] = given["units"].pop(name)
    in_joint()(given)


RECORDS = {
    "parameters a text": in_provenance(parameters="x"),
    "parameters of texts": in_provenance(parameters={"c": "1"}),
    "document no text": in_provenance(document=5),
    "document no JSON": in_provenance(document="x"),
    "document no table": in_provenance(document="[1]"),
    "document without end": in_provenance(document="[" * 100_000),
    "method a list": in_provenance(method=[1]),
    "end a text": in_provenance(t_end="x"),
    "tolerance a text": in_provenance(rtol="x"),
    "derivatives of numbers": in_provenance(of=[5]),
    "changes without size": in_provenance(changes={"c": {"unit": "m", "words": ""}}),
    "drift beyond all numbers": in_trust(drift=10**400),
    "impacts beyond all numbers": in_trust(impacts=-(10**400)),
    "event beyond all numbers": put(events=[[10**400, "O", "impact"]]),
    "peaks beyond all numbers": put(peaks={"O.normal": [10**400, 0, 0]}),
    "steps beyond all numbers": put(stats={"steps": 10**400}),
    "film without oil": film_without_oil,
    "drift no number": in_trust(drift=None),
    "drift of angles a text": in_trust(drift_angle="=1"),
    "horizon a list": in_trust(horizon=[1]),
    "notes a number": in_trust(notes=5),
    "notes of numbers": in_trust(notes=[5]),
    "pulled a list": in_trust(pulled=[1]),
    "contacts a text": in_trust(contacts="many"),
    "stopped a number": in_trust(stopped=1),
    "oil without heat": in_joint(oil={"boundary": 1e-6, "density": 900.0}),
    "oil of texts": in_joint(oil={"boundary": 1e-6, "density": 900.0, "specific_heat": "=1"}),
    "oil a number": in_joint(oil=5),
    "joint without bodies": in_joint(bodies=[]),
    "joint of strangers": in_joint(bodies=["arm", "leg"]),
    "clearance a text": in_joint(clearance="1"),
    "stop of one end": in_joint(stop=[1]),
    "driven a stranger": lambda given: given["geometry"].update(driven=["M"]),
    "loads a list": lambda given: given["geometry"].update(loads=[1]),
    "peaks of texts": put(peaks={"O.normal": ["a", "b", "c"]}),
    **{f"no {key}": without(key) for key in ("geometry", "events", "trust", "success", "stats", "units")},
    "message no text": put(message=5),
    "success no truth": put(success="yes"),
    "events no list": put(events=5),
    "event too short": put(events=[[1]]),
    "event too long": put(events=[[0.0, "O", "impact", *range(50)]]),
    "event of texts": put(events=[["a", "b", "c"]]),
    "event not a list": put(events=[5]),
    "trust with more": lambda given: given["trust"].update(more=1),
    "trust with less": lambda given: given["trust"].pop("intervals"),
    "intervals no numbers": lambda given: given["trust"].update(intervals={"O": "x"}),
    "geometry a list": put(geometry=[]),
    "bodies a list": lambda given: given["geometry"].update(bodies=[1]),
    "points no pairs": lambda given: given["geometry"].update(bodies={"arm": {"points": {"P": [1]}}}),
    "body no table": lambda given: given["geometry"].update(bodies={"arm": 5}),
    "unit no text": lambda given: given["units"].update(lift=5),
    "unit with escape": lambda given: given["units"].update(lift="\x1b[2J"),
    "breaks a number": put(breaks=5),
    "breaks no rows": put(breaks="AAAAAAAAAAA="),
    "breaks no text of numbers": put(breaks="="),
    "breaks that go back": put(
        breaks=base64.b64encode((-np.arange(2.0 * (1 + len(circling(5).stored)))).tobytes()).decode()
    ),
    "format no number": put(format="2"),
    "format true": put(format=True),
    "format negative": put(format=-1),
}


@pytest.mark.parametrize("case", RECORDS)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_records_that_no_result_has_are_refused(tmp_path, monkeypatch, case, suffix):
    """With the right checksum: such a file was made by hand."""
    given, r = record(), circling(5)
    RECORDS[case](given)
    units = {"units": {}} if not isinstance(given.get("units"), dict) else {}
    text = json.dumps({"format": archive.FORMAT, **given})
    curves = {name: r[stored] for name, stored in zip(given["names"], r.stored, strict=True)}
    digest = archive._digest(text, r.t, list(curves.values()))
    make = archive._netcdf if suffix == "nc" else archive._npz
    names = {name: str(one) for name, one in {**dict.fromkeys(r.stored, ""), **given.get("units", units)}.items()}
    (tmp_path / f"h.{suffix}").write_bytes(make(text, digest, r.t, curves, names))
    with pytest.raises(ValueError, match="not a result of rattle"):
        load_result(tmp_path / f"h.{suffix}")


@pytest.mark.parametrize(
    "t",
    [[0.0, 1.0, np.nan, 3.0, 4.0], [np.nan] * 5, [0.0] * 5, [4.0, 3.0, 2.0, 1.0, 0.0], [0.0, 1.0, 2.0, 3.0, np.inf]],
)
def test_instants_that_are_not_in_order_are_refused(tmp_path, t):
    archive.write(tmp_path / "h.npz", record(), np.array(t), circling(5)._data)
    with pytest.raises(ValueError, match="instants are not in order"):
        load_result(tmp_path / "h.npz")


@pytest.mark.parametrize(
    "text", ["[" * 100_000, "[1]", "5", "", "{}", '{"names": 5, "format": 2}', '{"names": 1' + "0" * 5000]
)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_texts_that_are_no_record_are_refused(tmp_path, text, suffix):
    r = circling(5)
    make = archive._netcdf if suffix == "nc" else archive._npz
    (tmp_path / f"h.{suffix}").write_bytes(make(text, archive._digest(text, r.t, []), r.t, {}, {}))
    with pytest.raises(ValueError, match="not a result of rattle"):
        load_result(tmp_path / f"h.{suffix}")


@pytest.mark.parametrize("name", ["=HYPERLINK(1)", "a\x1b[2J", "", "+1", "a\nb"])
def test_names_that_a_table_would_run_or_a_terminal_obey_are_refused(tmp_path, name):
    r = circling(5)
    given = {**record(), "names": [name], "units": {name: "m"}}
    archive.write(tmp_path / "h.npz", given, r.t, r._data[:, :1])
    with pytest.raises(ValueError, match="not a result of rattle"):
        load_result(tmp_path / "h.npz")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_of_a_later_format_asks_for_a_newer_rattle(tmp_path, monkeypatch, suffix):
    with monkeypatch.context() as later:
        later.setattr(archive, "FORMAT", archive.FORMAT + 1)
        circling(3).save(tmp_path / f"r.{suffix}")
    with pytest.raises(ValueError, match="install a newer one"):
        load_result(tmp_path / f"r.{suffix}")


def test_a_file_of_the_first_format_is_read(tmp_path):
    """It has units at its curves only, and no checksum."""
    import xarray

    r, given = circling(5), record()
    curves = {name: ("t", r[name], {"units": r.unit(name)}) for name in r.stored}
    dataset = xarray.Dataset(curves, {"t": ("t", r.t, {"units": "s"})})
    del given["units"]
    dataset[archive.RECORD] = ((), json.dumps({**given, "format": 1}))
    dataset.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    assert same(load_result(tmp_path / "old.nc"), r)


# ---------------------------------------------------------------- without other packages
@pytest.mark.parametrize("missing", ["xarray", "h5py", "h5netcdf", "pandas"])
def test_an_npz_needs_no_other_package(tmp_path, monkeypatch, missing):
    monkeypatch.setitem(sys.modules, missing, None)
    r, _ = saved(tmp_path, "npz")
    assert same(load_result(tmp_path / "r.npz"), r)
    with np.load(tmp_path / "r.npz", allow_pickle=False) as plain:
        assert np.array_equal(plain["O.normal"], r["O.normal"])
        assert np.array_equal(plain["t"], r.t)


def test_a_result_without_any_instant_is_saved_too(tmp_path):
    for suffix in SUFFIXES:
        r = circling(1)
        r.t, r._data = r.t[:0], r._data[:0]
        r.save(tmp_path / f"r.{suffix}")
        assert len(load_result(tmp_path / f"r.{suffix}").t) == 0


def test_numbers_of_a_pickled_result_cannot_be_changed():
    r = pickle.loads(pickle.dumps(circling(5)))
    for values in (r.t, r["lift"]):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0


def test_another_place_is_tried_where_the_disk_is_full(tmp_path, monkeypatch):
    real = archive.atomic

    def full(path):
        if path.parent == tmp_path:
            raise OSError(28, "No space left on device")
        return real(path)

    monkeypatch.setattr(archive, "atomic", full)
    (tmp_path / "other").mkdir()
    r = circling(5)
    for suffix in SUFFIXES:
        with pytest.raises(OSError, match="No space"):
            r.save(tmp_path / f"r.{suffix}")
        assert r.save(tmp_path / f"r.{suffix}", fallback=tmp_path / "other") == tmp_path / "other" / f"r.{suffix}"
        assert same(load_result(tmp_path / "other" / f"r.{suffix}"), r)
