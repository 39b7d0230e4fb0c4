"""Numbers as they are printed: so many digits, and no more."""

import math
import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Digits:
    """A printed number: its text, its value, and the unit of its last digit.

    Angles, in degrees and minutes, have a value in degrees.
    """

    text: str
    value: float
    unit: float
    angle: bool = False

    def like(self, value: float, *, cut: bool = False) -> "Digits":
        """`value` with as many digits, rounded or cut off."""
        count = math.floor(value / self.unit + (1e-9 if cut else 0.5))
        if self.angle:
            degrees, minutes = divmod(count, 60)
            return digits(f"{degrees}°{minutes:02}'")
        return digits(f"{count * self.unit:.{round(-math.log10(self.unit))}f}")

    @property
    def figures(self) -> str:
        """The digits alone, leading zeros dropped."""
        return re.sub(r"\D", "", self.text).lstrip("0")


def digits(text: str) -> Digits:
    """A cell as printed: 0.7265, 4°46', or 1.— for a whole number."""
    angle = re.fullmatch(r"(\d+)°(\d+)'", text)
    if angle:
        minutes = 60 * int(angle[1]) + int(angle[2])
        return Digits(text, minutes / 60.0, 1.0 / 60.0, angle=True)
    plain = text.replace("—", "0000")
    places = len(plain.partition(".")[2])
    return Digits(text, float(plain), 10.0**-places)
