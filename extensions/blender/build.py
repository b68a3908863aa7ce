# SPDX-License-Identifier: MIT OR Apache-2.0
"""Builds the extension's packages, one per wheel of the Python package:

    pip wheel ./crates/python --no-deps --wheel-dir target/wheels
    python extensions/blender/build.py target/wheels/*.whl --out target/extension
"""

import argparse
import re
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
SOURCES = sorted(path for path in HERE.glob("*.py") if path.name != "build.py")
# The platform tags of wheels, and Blender's names for them.
PLATFORMS = {
    r"(many)?linux.*_x86_64": "linux-x64",
    r"(many)?linux.*_aarch64": "linux-arm64",
    r"macosx.*_x86_64": "macos-x64",
    r"macosx.*_arm64": "macos-arm64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
}


def platform(wheel):
    """Blender's name for the wheel's platform."""
    tag = wheel.stem.split("-")[-1]
    for pattern, name in PLATFORMS.items():
        if re.fullmatch(pattern, tag):
            return name
    raise SystemExit(f'{wheel.name}: Blender has no platform for "{tag}"')


def manifest(wheel):
    """The manifest with the platform and the wheel inserted before its first table."""
    head, permissions = (HERE / "blender_manifest.toml").read_text().split("\n[", 1)
    head = re.sub(r"\n# build\.py adds.*\n", "\n", head)
    return f'{head}platforms = ["{platform(wheel)}"]\nwheels = ["./wheels/{wheel.name}"]\n\n[{permissions}'


def build(wheel, out):
    """Writes the package for one wheel and returns its path."""
    version = wheel.name.split("-")[1]
    package = out / f"wgdenoise-{version}-{platform(wheel)}.zip"
    out.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(package, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("blender_manifest.toml", manifest(wheel))
        for source in SOURCES:
            archive.write(source, source.name)
        for name in ("LICENSE-MIT", "LICENSE-APACHE"):
            archive.write(REPOSITORY / name, name)
        archive.write(wheel, f"wheels/{wheel.name}")
    return package


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheels", type=Path, nargs="+", help="wheels of crates/python")
    parser.add_argument("--out", type=Path, default=Path("target/extension"), help="folder for the packages")
    o = parser.parse_args()
    for wheel in o.wheels:
        print(build(wheel, o.out))


if __name__ == "__main__":
    main()
