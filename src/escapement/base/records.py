"""Records of what was computed, which print themselves from the declarations of their values."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from escapement.base.results import Result
from escapement.base.text import plain, print_columns, print_values, show, words
from escapement.base.units import factor, printed

Results = Mapping[str, Result]
"""Declarations by name, which is the JSON key too."""


class Row(NamedTuple):
    """A line of a table of single values."""

    name: str
    value: str
    unit: str
    meaning: str


class Table(NamedTuple):
    """A table with names and units of its columns."""

    title: str
    names: Sequence[str]
    units: Sequence[str]
    rows: Sequence[Sequence[Any]]

    def show(self) -> None:
        """Print it, with the units below the names."""
        if self.title:
            print(self.title)
        print_columns([self.names, *[self.units] * any(self.units)], self.rows)


@dataclass(frozen=True)
class Record:
    """What was computed, in SI, by name; keys that end in "_deg" are angles in degrees.

    A value may be a number, a word, a list of these, or an object, whose values are told one by
    one. A list of objects, and an object of objects, has a table of its own.
    """

    values: Mapping[str, Any]
    results: Results = field(default_factory=dict)

    def __or__(self, other: "Record") -> "Record":
        """All values and declarations of both."""
        return Record({**self.values, **other.values}, {**self.results, **other.results})

    def without(self, *names: str) -> "Record":
        """The same without some values."""
        kept = {name: value for name, value in self.values.items() if name not in names}
        return Record(kept, self.results)

    def _result(self, name: str) -> Result:
        usual = Result("degrees" if name.endswith("_deg") else "ratio")
        return self.results.get(name, usual)

    def _inner(self, values: Mapping[str, Any]) -> "Record":
        return Record(values, self.results)

    def in_units(self, system: str) -> dict[str, Any]:
        """The values in a system of units, for JSON."""

        def told(name: str, value: Any) -> Any:
            if isinstance(value, Mapping):
                return self._inner(value).in_units(system)
            if isinstance(value, list) and any(isinstance(one, Mapping) for one in value):
                return [told(name, one) for one in value]
            return in_units(value, self._result(name).kind, system)

        return {name: told(name, value) for name, value in self.values.items()}

    def reasons(self) -> list[str]:
        """Why numbers are missing, those for which that is declared."""
        found = []
        for name in self.values:
            value = plain(self.values[name])
            if value is None or (isinstance(value, list) and None in value):
                reason = self._result(name).missing
                found += [f"{name} is not given: {reason}"] if reason else []
        return found

    def rows(self, system: str) -> list[Row]:
        """Single values in a system of units, without what tables do not show."""
        rows = []
        for name, value in self.values.items():
            result = self._result(name)
            again = result.unlike and value == self.values[result.unlike]
            if again or not result.tabled or _lines(value):
                continue
            if isinstance(value, Mapping):
                inner = self._inner(value).rows(system)
                rows += [row._replace(name=f"{self.label(name)}, {row.name}") for row in inner]
                continue
            shown = show(in_units(value, result.kind, system), result.digits)
            unit = printed(result.kind, system) * (shown != "none")
            rows.append(Row(self.label(name), shown, unit, result.long_name))
        return rows

    def tables(self, system: str) -> Iterator[Table]:
        """The tables of objects."""
        for name, value in self.values.items():
            if (found := _lines(value)) and self._result(name).tabled:
                lines = [self._inner(line).in_units(system) for line in found]
                units = [printed(self._result(key).kind, system) for key in lines[0]]
                cells = [[*line.values()] for line in lines]
                yield Table(words(name), [*map(self.label, lines[0])], units, cells)

    def label(self, name: str) -> str:
        """The name of a value in tables."""
        return self._result(name).label or words(name)

    def show(self, system: str) -> None:
        """Print all as tables."""
        if rows := self.rows(system):
            print_values(row[:3] for row in rows)
        for i, table in enumerate(self.tables(system)):
            if rows or i:
                print()
            table.show()


def beside(records: Iterable[Record], system: str) -> list[list[str]]:
    """A row for each single value of several records: its name, the values, and its unit."""
    columns = [{row.name: row for row in one.rows(system)} for one in records]
    lines = []
    for name in dict.fromkeys(name for column in columns for name in column):
        rows = [column.get(name) for column in columns]
        unit = next((row.unit for row in rows if row is not None and row.unit), "")
        lines.append([name, *("-" if row is None else row.value for row in rows), unit])
    return lines


def _lines(value: Any) -> list[Mapping[str, Any]]:
    """The lines of a table of objects; none for any other value."""
    if isinstance(value, Mapping) and value and all(isinstance(x, Mapping) for x in value.values()):
        return [{"": words(name), **one} for name, one in value.items()]
    if isinstance(value, list) and any(isinstance(one, Mapping) for one in value):
        return value
    return []


def in_units(value: Any, kind: str, system: str) -> Any:
    """A value in SI, or each of several, in a system of units.

    Angles in degrees, whole numbers and whatever else has no unit stay as they are.
    """
    scale = 1.0 if kind == "degrees" else factor(kind, system)
    if scale == 1.0 or isinstance(value, bool | int | str) or value is None:
        return value
    if isinstance(value, Mapping):
        return {key: in_units(one, kind, system) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [in_units(one, kind, system) for one in value]
    return value / scale
