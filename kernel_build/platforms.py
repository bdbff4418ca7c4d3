"""The platforms for which the library is built: their names in LLVM, in zig, and in the names of wheels."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Platform:
    """A platform.

    Attributes
    ----------
    triple
        Name in LLVM; also of the form of object files.
    zig_target
        Name in zig, with the oldest version of the system, or of its C library, that the library needs.
    wheel_tag
        Name in the file of a wheel for the package index.
    cpu
        The least processor.
    """

    triple: str
    zig_target: str
    wheel_tag: str
    cpu: str = "generic"


PLATFORMS = {
    "linux-x86_64": Platform("x86_64-unknown-linux-gnu", "x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64", "x86-64"),
    "linux-aarch64": Platform("aarch64-unknown-linux-gnu", "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64"),
    "darwin-x86_64": Platform("x86_64-apple-macosx11.0.0", "x86_64-macos.11.0", "macosx_11_0_x86_64", "x86-64"),
    "darwin-arm64": Platform("arm64-apple-macosx11.0.0", "aarch64-macos.11.0", "macosx_11_0_arm64"),
    "win32-amd64": Platform("x86_64-w64-windows-gnu", "x86_64-windows-gnu", "win_amd64", "x86-64"),
}
"""Platforms for which wheels are built, by the names of `kernel_library.platform_name`."""
