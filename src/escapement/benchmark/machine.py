"""What the numbers were measured on: without it a time says nothing."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from escapement import __version__

_PACKAGES = ("numpy", "scipy", "numba", "heyoka", "CyRK")


def describe() -> dict[str, Any]:
    """Processor, cores, system and versions; nothing that names this machine."""
    versions = {name: _version(name) for name in _PACKAGES}
    return {
        "processor": _processor(),
        "cores": _cores(),
        "load": _load(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "escapement": __version__,
        **{name: found for name, found in versions.items() if found is not None},
    }


def in_a_line(machine: dict[str, Any]) -> str:
    """The same for the foot of a figure."""
    versions = ", ".join(
        f"{name} {machine[name]}" for name in ("python", *_PACKAGES) if name in machine
    )
    return f"{machine['processor']}, {machine['cores']} cores; {versions}"


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _processor() -> str:
    """The processor's model name, where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _load() -> float | None:
    """Processes that others keep running here, as an average over a minute."""
    return round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None


def _cores() -> int:
    """Cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
