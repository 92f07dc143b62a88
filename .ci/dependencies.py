"""Crates that are linked into the programs and libraries of a release, from `cargo metadata`."""

import json
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Tests are not released.
UNRELEASED = {"system-tests"}


@dataclass
class Crate:
    """Package with the identifiers of the crates that it links."""

    id: str
    name: str
    version: str
    licence: str
    licence_file: str | None
    authors: list[str]
    description: str
    folder: Path
    is_own: bool
    checksum: str | None
    dependencies: list[str]


def all_crates(target: str) -> list[Crate]:
    """Returns the crates of the workspace and every crate they link on `target`, by name and version."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    printed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout
    metadata = json.loads(printed)
    with (ROOT / "Cargo.lock").open("rb") as file:
        checksums = {(p["name"], p["version"]): p.get("checksum") for p in tomllib.load(file)["package"]}
    packages = {package["id"]: package for package in metadata["packages"]}
    # Build scripts and tests are not part of a program.
    links = {
        node["id"]: sorted(d["pkg"] for d in node["deps"] if any(kind["kind"] is None for kind in d["dep_kinds"]))
        for node in metadata["resolve"]["nodes"]
    }
    own = set(metadata["workspace_members"])
    reached: set[str] = set()
    pending = [id for id in own if packages[id]["name"] not in UNRELEASED]
    while pending:
        id = pending.pop()
        if id not in reached:
            reached.add(id)
            pending += links[id]
    crates = [
        Crate(
            id=id,
            name=package["name"],
            version=package["version"],
            licence=package["license"] or "see the licence file",
            licence_file=package["license_file"],
            authors=package["authors"],
            description=package["description"] or "",
            folder=Path(package["manifest_path"]).parent,
            is_own=id in own,
            checksum=checksums.get((package["name"], package["version"])),
            dependencies=links[id],
        )
        for id, package in packages.items()
        if id in reached
    ]
    return sorted(crates, key=lambda crate: (crate.name, crate.version))


def linked_crates(target: str) -> list[Crate]:
    """Returns the crates of other projects that the release links."""
    return [crate for crate in all_crates(target) if not crate.is_own]
