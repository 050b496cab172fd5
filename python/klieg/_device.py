"""Devices."""

from __future__ import annotations

from dataclasses import dataclass

from klieg import _klieg
from klieg._settings import native


@dataclass(frozen=True)
class DeviceInfo:
    """What can compute."""

    index: int
    """Its number, by which `Device` takes it."""
    name: str
    """Its own name."""
    type: str
    """`discrete`, `integrated`, `virtual`, `software` (Vulkan without a GPU), `cpu` (without Vulkan) or `other`."""
    driver: str
    """Driver's name and version; klieg's own for the CPU."""
    lacks: tuple[str, ...]
    """What it lacks to run klieg; empty where it can."""
    auto: bool
    """Whether it is the one that `auto` takes."""


def devices() -> list[DeviceInfo]:
    """Return the devices of this machine: those of Vulkan, if any, then the CPU."""
    return [DeviceInfo(*entry[:4], tuple(entry[4]), entry[5]) for entry in _klieg.devices()]


class Device:
    """A device that stays open, with its compiled pipelines: for many designs and evaluators in one process."""

    def __init__(self, device: str | int = "auto", *, pipeline: str | None = None, memory: int | None = None) -> None:
        """Open a device.

        Args:
            device: `auto` (a GPU, else the CPU), `vulkan`, `cpu`, or the number or a part of the name of one.
            pipeline: how a Vulkan device makes the pictures: `auto`, `layered`, `forward` or `compute`.
            memory: memory of a Vulkan device for the pictures of a population, MiB.

        Raises:
            InputError: for a device that is not there.
            Error: for one that does not work.

        """
        self._native = _klieg.Device(native({"device": str(device), "pipeline": pipeline, "memory": memory}))

    @property
    def name(self) -> str:
        """Its own name."""
        return self._native.info()[0]

    @property
    def type(self) -> str:
        """As `DeviceInfo.type`."""
        return self._native.info()[1]

    def __repr__(self) -> str:
        """Tell name and type."""
        return f"Device({self.name!r}, {self.type})"


def opened(device: str | int | Device) -> tuple[dict[str, str], _klieg.Device | None]:
    """Return the options of a device that has to be opened, and the device where it is open."""
    if isinstance(device, Device):
        # One that was named is not replaced by the CPU where it fails.
        return {"device": device.name}, device._native
    return {"device": str(device)}, None
