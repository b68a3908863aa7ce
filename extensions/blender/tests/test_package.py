# SPDX-License-Identifier: MIT OR Apache-2.0
"""The package: valid for Blender, one per platform, with the program's version."""

import importlib.util
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
import pytest
from conftest import PACKAGE, REPOSITORY

_SPEC = importlib.util.spec_from_file_location("build", REPOSITORY / "extensions/blender/build.py")
build = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(build)


def read_manifest(package):
    with zipfile.ZipFile(package) as archive:
        return tomllib.loads(archive.read("blender_manifest.toml").decode()), archive.namelist()


def test_blender_validates_the_package():
    tool = Path(bpy.utils.system_resource("SCRIPTS"), "addons_core/bl_pkg/cli/blender_ext.py")
    done = subprocess.run([sys.executable, str(tool), "validate", str(PACKAGE)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_has_the_program_s_version_and_all_its_files():
    manifest, names = read_manifest(PACKAGE)
    workspace = tomllib.loads((REPOSITORY / "Cargo.toml").read_text())
    assert manifest["version"] == workspace["workspace"]["package"]["version"]
    assert len(manifest["wheels"]) == 1 and manifest["wheels"][0].removeprefix("./") in names
    sources = {path.name for path in (REPOSITORY / "extensions/blender").glob("*.py")} - {"build.py"}
    assert sources <= {*names} and {"LICENSE-MIT", "LICENSE-APACHE"} <= {*names}


@pytest.mark.parametrize(
    ("tag", "platform"),
    [
        ("manylinux_2_28_x86_64", "linux-x64"),
        ("linux_x86_64", "linux-x64"),
        ("macosx_11_0_arm64", "macos-arm64"),
        ("macosx_10_12_x86_64", "macos-x64"),
        ("win_amd64", "windows-x64"),
    ],
)
def test_a_wheel_s_platform_is_blender_s(tmp_path, tag, platform):
    wheel = tmp_path / f"wgdenoise-0.1.0-cp39-abi3-{tag}.whl"
    wheel.touch()
    manifest, names = read_manifest(build.build(wheel, tmp_path))
    assert manifest["platforms"] == [platform] and f"wheels/{wheel.name}" in names


def test_a_wheel_for_no_platform_of_blender_is_refused(tmp_path):
    with pytest.raises(SystemExit, match="no platform"):
        build.build(tmp_path / "wgdenoise-0.1.0-cp39-abi3-musllinux_1_2_riscv64.whl", tmp_path)
