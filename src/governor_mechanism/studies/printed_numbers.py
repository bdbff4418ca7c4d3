"""Numbers as a paper prints them, beside the recomputed ones."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PrintedNumber:
    """One number of a paper in `unit`, printed and recomputed; misprint describes the error, if there is one."""

    quantity: str
    unit: str
    printed: float
    recomputed: float
    misprint: str = ""

    @property
    def cells(self) -> tuple[str, ...]:
        """The number as a row of a table."""
        misprint = f"MISPRINT: {self.misprint}" if self.misprint else ""
        return self.quantity, self.unit, f"{self.printed:.6g}", f"{self.recomputed:.7g}", misprint
