"""STEP files through OpenCASCADE in its own process: what is taken, what is refused, and that nothing crashes."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from import_makers import STEP, _glb, box, written
from step_makers import (
    added,
    assembly,
    block,
    coloured,
    drawn,
    number_of,
    referring,
    step,
    tessellated,
    without_face,
)

from hognose.errors import InputError, MissingExtraError
from hognose.scene import Mesh, Scene
from hognose.scene.imports import opencascade, reading
from hognose.scene.imports import step as step_module
from hognose.scene.imports.step_glb import read_made

GROWN = np.array([[-5e-5], [5e-5]])


def read(folder, text):
    item = Mesh(file=str(written(folder, "step", text.encode())))
    assert item.geometry is not None
    return item


def refusal(folder, text):
    with pytest.raises(InputError) as caught:
        read(folder, text)
    assert str(caught.value).startswith(str(folder / "file.step"))
    return str(caught.value)


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    """One file with: a part at two places, one with a coloured face, one in inches, one of triangles, a sketch."""
    text = step(block("bolt"), block("painted", (0.0, 300.0, 0.0)), block("inch part", (0.0, 0.0, 2.0), 1.0, 3.0))
    text = coloured(text, number_of(text, "ADVANCED_FACE", 8), number_of(text, "GEOMETRIC_REPRESENTATION_CONTEXT", 1))
    text = in_inches(text, number_of(text, "LENGTH_UNIT", 2))
    text = assembly(text, (500.0, 0.0, 0.0), (1000.0, 0.0, 50.0))
    text = added(added(text, *tessellated("tet")), *drawn("sketch"))
    folder = tmp_path_factory.mktemp("step")
    return read(folder, added(text, *referring("lid.stp", "shell.stp")))


def in_inches(text, unit):
    entity = f"#{unit}=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"
    assert entity in text
    text = text.replace(entity, f"#{unit}=(CONVERSION_BASED_UNIT('INCH',#9002)LENGTH_UNIT()NAMED_UNIT(#9001));")
    return text.replace(
        "\nENDSEC;\nEND-ISO",
        "\n#9001=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n#9002=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9003);\n"
        "#9003=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\nENDSEC;\nEND-ISO",
    )


def test_bodies_are_called_after_their_products_and_are_where_they_should_be(everything):
    scene = Scene.from_obstacles([everything])
    found = {name.removeprefix("file: "): scene.bounds[k] - GROWN for k, name in enumerate(scene.names)}
    expected = {
        # Turned by 90° about z: x of the part is y of the assembly.
        "bolt": ((400, 0, 0), (500, 100, 100)), "bolt 2": ((900, 0, 50), (1000, 100, 150)),
        "painted": ((0, 300, 0), (100, 400, 100)), "inch part": ((0, 0, 50.8), (25.4, 25.4, 127)),
        "tet": ((0, 0, 0), (100, 100, 100)),
    }  # fmt: skip
    assert found.keys() == expected.keys()
    for name, (low, high) in expected.items():
        np.testing.assert_allclose(found[name], 1e-3 * np.array([low, high]), atol=1e-7)


def test_a_body_with_a_coloured_face_is_one_and_watertight(everything):
    assert [body.watertight for body in everything.geometry.bodies] == [True] * 5
    inside = Scene.from_obstacles([everything]).inside([[0.05, 0.35, 0.05], [0.45, 0.05, 0.05], [0.01, 0.01, 0.06]])
    assert (inside >= 0).all()


def test_what_is_not_taken_is_noted(everything):
    said = "\n".join(everything.remarks())
    assert "refers to other files, which are not read: lid.stp, shell.stp" in said
    assert "1 curve of no face left out" in said
    assert "4 of its faces are triangles in the file, which does not say how far they lie off" in said
    assert len(everything.remarks()) == 3


def test_a_face_that_is_missing_is_refused(tmp_path):
    lost = step(block("a"), block("b")).replace("ADVANCED_FACE", "ADVANCED_FARCE", 1)
    assert "made triangles of only 11 of its 12 faces" in refusal(tmp_path, lost)


def test_a_closed_shell_with_a_hole_is_refused(tmp_path):
    """Even if the number of faces is right: the file itself lacks one."""
    text = step(block("a"), block("b", (300.0, 0.0, 0.0)))
    said = refusal(tmp_path, without_face(text, number_of(text, "ADVANCED_FACE", 8)))
    assert "the solid 'b' is closed in the file, but OpenCASCADE left a gap of 100 mm in it, at (" in said


def test_a_part_that_lost_its_place_is_refused(tmp_path):
    """All its faces are there, at the other place; OpenCASCADE says nothing."""
    text = assembly(step(block()), (0.0, 0.0, 0.0), (500.0, 0.0, 0.0))
    last = "\n#" + str(number_of(text, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", 1)) + "="
    said = refusal(tmp_path, text.replace(last, last + "X"))
    assert "put only 1 of its 2 parts in their places" in said


def test_an_open_surface_is_allowed_and_said_to_be_one(tmp_path):
    text = (
        step(block())
        .replace("CLOSED_SHELL", "OPEN_SHELL")
        .replace("MANIFOLD_SOLID_BREP('block',", "SHELL_BASED_SURFACE_MODEL('block',(")
    )
    text = re.sub(r"(SHELL_BASED_SURFACE_MODEL\('block',\(#\d+)\)", r"\1))", text)
    text = text.replace("ADVANCED_BREP_SHAPE_REPRESENTATION", "MANIFOLD_SURFACE_SHAPE_REPRESENTATION")
    item = read(tmp_path, without_face(text, number_of(text, "ADVANCED_FACE", 3)))
    (remark,) = item.remarks()
    assert "not watertight: 4 open edges" in remark
    assert "say `solid = false`" in remark


def test_only_references_to_other_files_are_refused(tmp_path):
    text = added(STEP["step_file"]([]), *referring("lid.stp"))
    assert "no geometry itself, but refers to other files: lid.stp. Name these as obstacles" in refusal(tmp_path, text)


def test_solids_that_opencascade_does_not_make_are_refused_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(step_module, "_converted", None)
    text = added(step(), "BLOCK('',$,1.,2.,3.)")
    assert "holds shapes that OpenCASCADE makes no surfaces of (BLOCK)" in refusal(tmp_path, text)


def test_no_unit_is_noted(tmp_path):
    (remark,) = read(tmp_path, step().replace("LENGTH_UNIT()", "")).remarks()
    assert "does not say its unit of length: read as mm" in remark


@pytest.mark.parametrize("data", [b"\x1f\x8b\x08\0rest", b"PK\3\4rest"])
def test_a_packed_file_is_told_to_be_unpacked(data, tmp_path):
    with pytest.raises(InputError, match="a packed STEP file; unpack it"):
        assert Mesh(file=str(written(tmp_path, "step", data))).geometry


def stand_in(folder, monkeypatch, code):
    """Something else in the place of the module that runs OpenCASCADE."""
    file = folder / "stand_in.py"
    file.write_text(code)
    monkeypatch.setattr(opencascade, "__file__", str(file))


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", r"OpenCASCADE crashed on it \(SIGSEGV\)"),
        ("import os; os.abort()", r"OpenCASCADE crashed on it \(SIGABRT\)"),
        ("raise SystemExit(1)", r"OpenCASCADE crashed on it \(exit code 1\)"),
        ("print('nonsense')", r"OpenCASCADE crashed on it \(exit code 0\)"),
        ("raise SystemExit(4)", "damaged, or not a STEP file that OpenCASCADE can read"),
        ("import time; time.sleep(60)", r"OpenCASCADE was not done with it after 1 s; give a larger `tolerance`"),
    ],
)
def test_whatever_becomes_of_the_process_is_a_message(code, said, tmp_path, monkeypatch):
    stand_in(tmp_path, monkeypatch, code)
    monkeypatch.setattr(step_module, "LONGEST", 1.0)
    with pytest.raises(InputError, match=rf"file\.step: {said}"):
        assert Mesh(file=str(written(tmp_path, "step", step().encode())), tolerance=1.1e-4).geometry


def test_a_package_that_does_not_work_is_named(tmp_path, monkeypatch):
    stand_in(tmp_path, monkeypatch, "import sys; sys.stderr.write('libX is missing'); sys.exit(3)")
    with pytest.raises(MissingExtraError, match="cascadio does not work: libX is missing; install it again"):
        assert Mesh(file=str(written(tmp_path, "step", step().encode())), tolerance=1.1e-4).geometry


def test_without_python_to_start_it_is_said(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "no-python"))
    with pytest.raises(InputError, match=r"cannot start .*no-python"):
        assert Mesh(file=str(written(tmp_path, "step", step().encode())), tolerance=1.1e-4).geometry


def test_interrupted_it_leaves_no_process_behind(tmp_path, monkeypatch):
    mark = tmp_path / "started"
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a shell's background
    stand_in(
        tmp_path, monkeypatch, f"import os, time; open({str(mark)!r}, 'w').write(str(os.getpid())); time.sleep(60)"
    )

    def interrupt():
        while not mark.exists() or not mark.read_text():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        assert Mesh(file=str(written(tmp_path, "step", step().encode())), tolerance=1.1e-4).geometry
    thread.join()
    signal.signal(signal.SIGINT, before)
    with pytest.raises(ProcessLookupError):
        os.kill(int(mark.read_text()), 0)


def test_the_process_ends_itself_even_if_nobody_waits_for_it():
    """Its time is counted from its start, so input that never comes is no way to stay."""
    arguments = [sys.executable, "-P", opencascade.__file__, "/nowhere", "0.05", "0.35", "0.2"]
    with subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.wait(60) == -signal.SIGALRM


SCRIPT = """
import os, sys
for number in map(int, sys.argv[2]):
    os.close(number)
from hognose.scene import Mesh
names = [body.name for body in Mesh(file=sys.argv[1]).geometry.bodies]
os._exit(0 if names == ["block"] else 1)
"""


@pytest.mark.parametrize("closed", ["", "012"])
def test_a_plain_script_reads_step_with_any_standard_streams(closed, tmp_path):
    """One without `if __name__ == "__main__"`, in another folder, whose modules are called as the library's."""
    (tmp_path / "run.py").write_text(SCRIPT)
    for name in ("cascadio", "signal", "contextlib"):
        (tmp_path / "elsewhere" / f"{name}.py").parent.mkdir(exist_ok=True)
        (tmp_path / "elsewhere" / f"{name}.py").write_text("raise SystemExit('the wrong one')")
    file = written(tmp_path, "step", step().encode())
    environment = {**os.environ, "HOGNOSE_CACHE": "off"}
    command = [sys.executable, str(tmp_path / "run.py"), str(file), closed]
    done = subprocess.run(command, cwd=tmp_path / "elsewhere", env=environment, check=False)
    assert done.returncode == 0


def test_what_was_read_is_what_is_kept_even_if_the_file_is_replaced_meanwhile(tmp_path, monkeypatch):
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "kept"))
    file = written(tmp_path, "step", step(block("first")).encode())
    really = reading._content

    def replaced_afterwards(path: Path) -> bytes:
        data = really(path)
        path.write_bytes(step(block("second", size=50.0)).encode())
        return data

    monkeypatch.setattr(reading, "_content", replaced_afterwards)
    assert np.ptp(Mesh(file=str(file)).geometry.vertices, axis=0) == pytest.approx([0.1, 0.1, 0.1])
    monkeypatch.setattr(reading, "_content", really)
    assert np.ptp(Mesh(file=str(file)).geometry.vertices, axis=0) == pytest.approx([0.05, 0.05, 0.1])


def test_a_mirrored_part_is_the_right_way_round():
    """OpenCASCADE writes a mirrored place as a matrix."""
    data = _glb(box().vertices * 1e-3, box().faces)
    plain = read_made(data).bodies[0]
    matrix = "[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]"
    length = int.from_bytes(data[12:16], "little")
    text = data[20 : 20 + length].replace(b'"mesh": 0,', b'"mesh": 0, "matrix": ' + matrix.encode() + b",")
    glb = data[:12] + len(text).to_bytes(4, "little") + data[16:20] + text + data[20 + length :]
    mirrored = read_made(glb).bodies[0]
    volumes = [np.linalg.det(body.vertices[body.faces]).sum() / 6 for body in (plain, mirrored)]
    assert volumes[0] == pytest.approx(0.2 * 0.3 * 0.4)
    assert volumes[1] == pytest.approx(volumes[0])
    np.testing.assert_allclose(mirrored.vertices, plain.vertices * [-1, 1, 1])
