"""`colcon build` in a fresh workspace, and what it installs.

Slow where cargo has built nothing yet: only with HANDOVER_COLCON=1, as `./test --all` has it."""

import os
import pathlib
import shutil
import subprocess

import pytest

from processes import Programs, wait_for

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()

pytestmark = [
    pytest.mark.skipif(os.environ.get("HANDOVER_COLCON") != "1",
                       reason="colcon build: HANDOVER_COLCON=1 runs it"),
    pytest.mark.xdist_group("colcon")]


def command(*words, folder, environment=None, seconds=1500):
    done = subprocess.run([str(word) for word in words], cwd=folder, text=True, timeout=seconds,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, env={**os.environ, **(environment or {})})
    return done.returncode, done.stdout


@pytest.fixture(scope="module")
def workspace(tmp_path_factory):
    """A workspace whose only package is this checkout, built; its path has a space."""
    assert shutil.which("colcon"), "no colcon: it is in Debian's python3-colcon-common-extensions"
    folder = tmp_path_factory.mktemp("a workspace")
    (folder / "src").mkdir()
    (folder / "src" / "handover_mesh").symlink_to(ROOT)
    code, said = command("colcon", "list", "--names-only", folder=folder)
    assert code == 0 and said.split() == ["handover_mesh"], said
    # As the other tests' programs are built, so that nothing is built twice.
    code, said = command(
        "colcon", "build", "--event-handlers", "console_direct+", "--cmake-args",
        "-DHANDOVER_PROFILE=dev", f"-DHANDOVER_CARGO_TARGET={TARGET}", folder=folder)
    assert code == 0, said
    return folder


def test_programs_launch_files_and_parameters_are_installed(workspace):
    share = workspace / "install/handover_mesh/share/handover_mesh"
    for name in ["config/handover.yaml", "package.xml", *(
            f"launch/{name}.launch.py" for name in ["handover", "record", "replay"])]:
        assert (share / name).is_file(), name
    sources = {path.name for path in (ROOT / "sim/scenarios").iterdir()}
    assert {path.name for path in (share / "sim/scenarios").iterdir()} == sources
    for program in ["handover", "handover_node", "handover_sim"]:
        path = workspace / "install/handover_mesh/lib/handover_mesh" / program
        assert os.access(path, os.X_OK), program


def test_installed_programs_start(workspace, work, ros):
    # In the environment that a user has who sourced the workspace.
    code, said = command("bash", "-c", ". install/setup.bash && env -0", folder=workspace)
    assert code == 0, said
    sourced = dict(line.split("=", 1) for line in said.split("\0") if "=" in line)
    # The hooks that ament makes do nothing where the path of ROS itself has a space.
    if " " not in os.environ["AMENT_PREFIX_PATH"]:
        assert str(workspace / "install/handover_mesh") in sourced["AMENT_PREFIX_PATH"]
    installed = Programs([workspace / "install/handover_mesh/lib/handover_mesh"], work)
    assert "handover" in installed.run("handover", "--help")
    assert "generate" in installed.run("handover_sim", "--help")
    installed.start("handover_node", name="installed", environment=sourced)
    wait_for(lambda: "/installed" in ros.nodes(), what="the installed node in the graph")
    installed.stop_all()


@pytest.mark.parametrize(("answer", "words"), [
    ("echo cargo 1.60.0 '(d1fd9fe2c 2022-03-01)'", "is needed"),
    ("echo 'no default toolchain' >&2; exit 1", "no default toolchain")])
def test_a_rust_that_is_too_old_or_broken_is_named(work, answer, words):
    cargo = work / "cargo"
    cargo.write_text(f"#!/bin/sh\n{answer}\n")
    cargo.chmod(0o755)
    code, said = command("cmake", "-S", ROOT, "-B", work / "build", f"-DCARGO={cargo}", folder=work)
    assert code != 0
    assert words in " ".join(said.split()) and "rustup" in said, said


def test_a_missing_cargo_and_an_unknown_ros_are_named(work):
    paths = os.environ["PATH"].split(":")
    without = ":".join(path for path in paths if not os.path.exists(os.path.join(path, "cargo")))
    environment = {"PATH": without, "HOME": str(work), "CARGO_HOME": str(work)}
    if shutil.which("cargo", path=without + ":/usr/bin:/usr/local/bin") is None:
        code, said = command("cmake", "-S", ROOT, "-B", work / "a", folder=work,
                             environment=environment)
        assert code != 0 and "No cargo: install Rust by rustup" in " ".join(said.split()), said
    for distro, words in [("eloquent", "'eloquent' is not known"), ("", "No ROS 2 is sourced")]:
        code, said = command("cmake", "-S", ROOT, "-B", work / "b", folder=work,
                             environment={"ROS_DISTRO": distro})
        assert code != 0 and words in " ".join(said.split()), said
