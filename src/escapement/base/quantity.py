"""Declarations of everything that a user may set, each beside the field that holds it.

    torque: float = field(metadata=quantity("driving torque", "torque", exclusive=True, ...))

The check in the constructor, the option of the command line, the key of a study file, the axis of
a study, and units, name and label in files and figures are derived from the declaration. A class
that declares its fields in this way derives from `Declared`; `declared` gives its declarations.
"""

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from escapement.base import units, validate
from escapement.base.errors import UnknownArgument
from escapement.base.text import Shown

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray

T = TypeVar("T")
_KEY = "setting"
_ALWAYS_SHOWN = "friction", "load_torque"
_LAST_WHOLE = 2.0**53  # beyond this a double cannot represent every whole number
_METAVARS = {"torque": "M", "inertia": "I", "length": "R", "speed": "W", "time": "S"}


def per_class(function: Callable[[type], T]) -> Callable[[type], T]:
    """`functools.cache` for a function of a class; type checkers take no class as its key."""
    return cache(function)


@dataclass(frozen=True, kw_only=True)
class Setting:
    """Something that a user may set: its description, and its place.

    long_name : description in words.
    remedy : what to do about a value that breaks the rule.
    name : of the option and the axis; by default that of the field.
    note : addition to the description in the help of the command line.
    metavar : name of its value there.
    typical : value that the command line uses instead of the default if none is typed.
    required : whether files and the command line must give it.
    axis : whether a study may vary it.
    unit : its kind, as in `escapement.base.units.factor`.
    system : unit system of numbers that are read without a unit.
    slotted : True if only mechanisms with slots have it, False if only mechanisms without have
        it; all others keep its default.
    instead : name of the setting that other mechanisms have instead.
    needs : name of a number without which it has no effect.
    group : heading under which pages show it.
    key, section, default : filled in from the class that declares it: name of the field, table
        of a study file ("" is the top level), and default, None where there is none.
    """

    long_name: str
    remedy: str = ""
    name: str = ""
    note: str = ""
    metavar: str = ""
    typical: Any = None
    required: bool = False
    axis: bool = False
    unit: str = "ratio"
    system: str = units.SYSTEMS[0]
    slotted: bool | None = None
    instead: str = ""
    needs: str = ""
    group: str = ""
    key: str = ""
    section: str = ""
    default: Any = None

    @property
    def label(self) -> str:
        """Where the value stands in a file, for messages."""
        return f"{self.section}.{self.key}" if self.section else self.key

    @cached_property
    def size(self) -> float:
        """SI value of its unit."""
        return units.factor(self.unit, self.system)

    @property
    def printed_unit(self) -> str:
        """Its unit in SI, as messages write it; "" for a ratio."""
        return units.printed(self.unit, units.SYSTEMS[0])

    @property
    def help(self) -> str:
        """Its description on the command line."""
        units_shown = dict.fromkeys(units.printed(self.unit, system) for system in units.SYSTEMS)
        unit = f" [{', '.join(units_shown)}]" if any(units_shown) else ""
        taken = self.typical if self.required else self.default
        shown = f"{taken:g}" if isinstance(taken, float) else taken
        default = "" if taken is None or isinstance(taken, bool | tuple) else f" (default: {shown})"
        return self.long_name + self.note + unit + default

    def applies_to(self, meshed: bool) -> bool:
        """Whether a mechanism without slots (`meshed`), or one with slots, has this."""
        return self.slotted is None or self.slotted is not meshed

    def idle(self, value: Any) -> bool:
        """Whether `value` is a zero that need not be shown, as of a bearing without friction."""
        if value != self.default:
            return False
        if isinstance(value, str):
            return not self.required
        return value == 0.0 and isinstance(self.default, float) and self.name not in _ALWAYS_SHOWN

    def check(self, label: str, value: Any) -> Any:
        """`value` as Python stores it; raises InvalidValue if it breaks the rule."""
        return value

    def read(self, label: str, value: Any) -> Any:
        """As `check`, of a value in a study file."""
        return self.check(label, value)

    def parse(self, label: str, text: str) -> Any:
        """As `check`, of a word on the command line."""
        return self.check(label, text)

    def to_si(self, values: Any) -> Any:
        """Values that were read, in SI; those without a unit, as whole numbers, are unchanged."""
        return values if self.size == 1.0 else values * self.size


@dataclass(frozen=True, kw_only=True)
class Quantity(Setting):
    """A number.

    minimum, maximum, exclusive, below, whole, fraction : the rule. An exclusive minimum is not
        allowed itself, nor is the maximum if `below` is true; a fraction may be text, "1/2".
    half : whether a search has to choose a whole number and a half.
    scene : field of `model.scene.Scene` that holds it, divided by the natural unit of its kind.
    """

    minimum: float = 0.0
    maximum: float = math.inf
    exclusive: bool = False
    below: bool = False
    whole: bool = False
    half: bool = False
    fraction: bool = False
    axis: bool = True
    scene: str = ""

    def check(self, label: str, value: Any) -> Any:
        """`value` as a number that obeys the rule."""
        # the usual case first: a check must cost little compared with a motion of microseconds
        plain = type(value) is float and not (self.whole or self.fraction)
        if plain and math.isfinite(value) and self._within(value):
            return value
        if self.whole:
            most = int(min(self.maximum, _LAST_WHOLE))
            return validate.integer(label, value, int(self.minimum), self.remedy, most)
        if self.fraction:
            return validate.rational(label, value, self.remedy, self.maximum)
        remedy = _with_unit(self.remedy, self.unit, self.system)
        number = validate.number(label, value, remedy)
        if not self._within(number):
            raise validate.fail(label, self.rule, value, remedy)
        return number

    def _within(self, values: Any) -> Any:
        """Whether a number, or each of an array, is in the range."""
        low = values > self.minimum if self.exclusive else values >= self.minimum
        return low & (values < self.maximum if self.below else values <= self.maximum)

    @property
    def rule(self) -> str:
        """The range of a real number in words."""
        low = f"{'greater than' if self.exclusive else 'at least'} {self.minimum:g}"
        high = f"{'below' if self.below else 'at most'} {self.maximum:g}"
        return low if math.isinf(self.maximum) else f"{low} and {high}"

    def read(self, label: str, value: Any) -> Any:
        """As `check`; in a file 4.0 is a whole number too, and a fraction becomes a double.

        A number may come with its unit, "5 mN m", and is then returned in that of the system.
        """
        if self.whole and isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, str) and not (self.whole or self.fraction):
            remedy = _with_unit(self.remedy, self.unit, self.system)
            number = units.measured(label, value, self.unit, self.system, remedy)
            if not self._within(number):
                raise validate.fail(label, self.rule, value, remedy)
            value = number
        checked = self.check(label, value)
        return float(checked) if self.fraction else checked

    def read_all(self, label: str, values: "NDArray[float64]") -> "NDArray[Any]":
        """`values`, whole ones as integers; raises for the first that breaks the rule."""
        import numpy as np

        if self.fraction:
            return np.array([self.read(f"{label}[{i}]", x) for i, x in enumerate(values.tolist())])
        # an axis may be long: only the first number that breaks the rule is checked separately
        good = np.isfinite(values) & self._within(values)
        if self.whole:
            good &= (values == np.rint(values)) & (values <= _LAST_WHOLE)
        for i in np.flatnonzero(~good)[:1].tolist():
            self.read(f"{label}[{i}]", float(values[i]))
        return values.astype(np.int64) if self.whole else values

    def parse(self, label: str, text: str) -> Any:
        """As `read`, of what was typed on the command line; a fraction stays one."""
        value: Any = text
        if not self.fraction:
            # the check refuses a text that is not a number, and shows it as typed
            with contextlib.suppress(ValueError):
                value = int(text) if self.whole else float(text)
        return self.check(label, value) if self.fraction else self.read(label, value)


@cache
def _with_unit(remedy: str, unit: str, system: str) -> str:
    """A remedy that names its unit: "give the crank radius in m"."""
    name = units.printed(unit, system)
    if not name:
        return remedy
    what, comma, rest = remedy.partition(",")
    return f"{what} in {'inches' if name == 'in' else name}{comma}{rest}"


class Truth(Setting):
    """True or false; on the command line an option without a value."""

    def check(self, label: str, value: Any) -> bool:
        """`value` as a bool."""
        return validate.truth(label, value)


@dataclass(frozen=True, kw_only=True)
class Choice(Setting):
    """One of a few words."""

    allowed: tuple[str, ...]

    def check(self, label: str, value: Any) -> str:
        """`value` as one of the words."""
        return validate.choice(label, value, self.allowed)


class Numbers(Setting):
    """A list of numbers, with units or without; the constructor checks them further."""

    def read(self, label: str, value: Any) -> tuple[float, ...]:
        """`value` as a list of finite numbers."""
        if isinstance(value, str | Mapping) or not hasattr(value, "__iter__"):
            raise validate.fail(label, "a list of numbers", value, self.remedy)
        found = []
        for i, item in enumerate(value):
            element = f"{label}[{i}]"
            number = units.measured(element, item, self.unit, self.system, self.remedy)
            found.append(validate.number(element, number, self.remedy))
        return tuple(found)

    def parse(self, label: str, text: str) -> Any:
        """As `read`, of numbers with commas between them."""
        words: list[Any] = text.split(",")
        for i, word in enumerate(words):
            # the check refuses a text that is not a number, and shows it as typed
            with contextlib.suppress(ValueError):
                words[i] = float(word)
        return self.read(label, words)

    def to_si(self, values: Any) -> Any:
        """Values that were read, in SI."""
        return values if self.size == 1.0 else tuple(self.size * value for value in values)


class InputFile(Setting):
    """A file to read; only the command line has such an option."""

    def parse(self, label: str, text: str) -> Path:
        """The path."""
        return Path(text)


def quantity(long_name: str, unit: str = "ratio", **rule: Any) -> dict[str, Setting]:
    """Metadata of a field that holds a number; `rule` has the attributes of `Quantity`."""
    rule.setdefault("metavar", _METAVARS.get(unit, "X"))
    return {_KEY: Quantity(long_name=long_name, unit=unit, **rule)}


def setting(declaration: Setting) -> dict[str, Setting]:
    """Metadata of a field that holds no number."""
    return {_KEY: declaration}


class Declared(Shown):
    """Base of frozen dataclasses whose fields carry declarations."""

    section: ClassVar[str] = ""
    """Table of a study file that holds the fields; "" is the top level."""

    def __new__(cls, *args: Any, **keywords: Any) -> Self:
        """Refuse an unknown keyword, and name the nearest known one."""
        # Python's own TypeError would not name the nearest
        known = cls.__init__.__code__.co_varnames[1:]
        for name in keywords:
            if name not in known:
                remedy = validate.nearest(name, known)
                raise UnknownArgument(f"{cls.__name__} has no argument {name!r}; {remedy}")
        return object.__new__(cls)

    def _shown(self) -> list[tuple[str, Any, str]]:
        """The settings that differ from their defaults."""
        entries = {entry.key: entry for entry in declared(type(self)).values()}
        rows = []
        for name, value, _ in super()._shown():
            entry = entries.get(name)
            given = value is not None if entry is None else value != entry.default
            if given or (entry is not None and entry.required):
                rows.append((name, value, entry.printed_unit if entry else ""))
        return rows

    @property
    def settings(self) -> dict[str, Any]:
        """The values of its declared fields, by the names of options and axes."""
        values = vars(self)
        return {name: values[entry.key] for name, entry in declared(type(self)).items()}

    @property
    def by_key(self) -> dict[str, Any]:
        """The same by the names of keys in files."""
        values = vars(self)
        return {entry.key: values[entry.key] for entry in declared(type(self)).values()}

    def check_fields(self) -> None:
        """Replace the value of every declared field by the checked value."""
        values = vars(self)
        for entry in declared(type(self)).values():
            value = values[entry.key]
            # a default is known to obey its rule, and most fields have their default
            if value is not entry.default or entry.required:
                values[entry.key] = entry.check(entry.name, value)


@per_class
def declared(owner: type) -> dict[str, Setting]:
    """What a class declares, by the name of the option and the axis, in the order of its fields."""
    found = {}
    for field in fields(owner):
        if (entry := field.metadata.get(_KEY)) is None:
            continue
        # a declaration may have a default for files where the constructor has none
        open_ = field.default is MISSING
        default = entry.default if open_ else field.default
        found[entry.name or field.name] = replace(
            entry,
            name=entry.name or field.name,
            key=field.name,
            section=getattr(owner, "section", ""),
            default=default,
            required=entry.required or (open_ and default is None),
        )
    return found


@per_class
def quantities(owner: type) -> dict[str, Quantity]:
    """The numbers that a class declares, by name."""
    return {name: entry for name, entry in declared(owner).items() if isinstance(entry, Quantity)}


def like(owner: type, name: str, **changes: Any) -> dict[str, Setting]:
    """Metadata of a field that holds the same as another class's, except for `changes`."""
    return {_KEY: replace(declared(owner)[name], section="", key="", **changes)}


def check_number(owner: type, name: str, value: Any) -> Any:
    """`value`, in SI, as the number `name` of a class; raises InvalidValue."""
    return declared(owner)[name].check(name, value)
