"""The part of the command `measure` for beats, from a recording or from a text file."""

from collections.abc import Iterable
from functools import partial
from typing import Any

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.quantity import Truth
from escapement.cli import _arguments, _output
from escapement.cli._arguments import Arguments, Parser, UsageError, add_number, option
from escapement.mechanisms import DEFAULT_KIND, Geneva, kind_of
from escapement.model.escapement import model_settings
from escapement.model.inputs import inputs_of

_PARTS = "both", "pins", "slots"
_READINGS = (
    *("input_column", "output_column", "time_column", "angle_unit", "skip_rows"),
    *("phase", "offset", "resolution", "linearity"),
)
"""Options of readings, which beats have no use for."""
_BEATS = "nominal_rate", "pattern"


def add_options(parser: Parser) -> None:
    """Add the options of beats."""
    group = parser.add_argument_group("beats: a recording, or with --beats a text file")
    text = "DATA holds instants or intervals of beats"
    _arguments.add_setting(group, Truth(name="beats", long_name=text), default=False)
    text, remedy = "right number of beats an hour", "give the beats an hour, as 18000"
    add_number(group, "nominal_rate", text, "N", exclusive=True, remedy=remedy)
    text = "beats after which errors repeat (default: 2, or with --fit the pins)"
    remedy = "give a whole number of beats"
    add_number(group, "pattern", text, "N", minimum=1, whole=True, remedy=remedy)


def concern(args: Arguments) -> bool:
    """Whether the data are beats; UsageError for an option that they have no use for."""
    from escapement.measurement.recording import is_recording

    beats = args.beats or is_recording(args.data)
    for name in _READINGS if beats else _BEATS:
        if getattr(args, name) is not None:
            kind = "readings of encoders" if beats else "beats, which a recording or --beats names"
            raise UsageError(f"{option(name)} must come with {kind}, got {args.data}; leave it out")
    if beats and args.bins != "sturges":
        raise UsageError(
            f"--bins must come with readings of encoders, got {args.data}; leave it out"
        )
    if beats:
        args.bins = None
    return bool(beats)


def execute(args: Arguments) -> int:
    """Print rate, beat error and stability, and what a model says of the beats."""
    from escapement.measurement.measurement_record import record_of_beats
    from escapement.measurement.recording import is_recording

    kind = kind_of(args.kind or DEFAULT_KIND)
    for name in ("fit", *_arguments.owners(), *model_settings()) if kind.pitch is not None else ():
        if getattr(args, name) is not None:
            raise UsageError(
                f"{option(name)} must not come with beats of a {kind.kind} mechanism, which tell "
                "only rate and beat error; leave it out, or fit angles of the driver"
            )
    names = [] if args.fit in (None, "none") else [name.strip() for name in args.fit.split(",")]
    parts = names[:1] if {*names[:1]} <= {*_PARTS} else []
    run_up = args.fit is not None and not parts
    advised = "both" if kind is Geneva else "friction,torque"
    remedy = f"{advised}, or leave it out and give --pattern"
    escapement = read_model(args, _arguments.owners(), remedy)
    nominal, share = args.nominal_rate, {}
    if args.confidence is not None:
        share["confidence"] = args.confidence
    beats = esc.read_beats(args.data, nominal=nominal, time_unit=args.time_unit, run_up=run_up)
    fit: Any = None
    keeping = None
    if not run_up:
        pattern = args.pattern or (escapement.mechanism.pins if escapement else 2) or 2
        keeping = esc.timekeeping(beats, nominal=nominal, pattern=pattern, **share)
    try:
        if parts and escapement:
            fit = esc.fit_beats(beats, escapement, parts=parts[0], **share)
        elif escapement:
            fit = esc.fit_motion(beats, escapement, names, **share)
    except InvalidValue as error:
        raise UsageError(f"--fit: {error}") from None
    sound = esc.read_recording(args.data) if args.plot and is_recording(args.data) else None

    def plot(plots: Any) -> Any:
        return plots.plot_run_up(beats, fit) if run_up else plots.plot_timing(beats, keeping, sound)

    _output.save(
        args, lambda: partial(esc.write_readings, beats, args.output, force=args.force), plot
    )
    record = record_of_beats(beats, keeping, fit, args.units)
    _output.tell(args, record, inputs_of(escapement) if escapement else ())
    return 0


def read_model(args: Arguments, idle: Iterable[str], remedy: str) -> "esc.Escapement | None":
    """The escapement that --fit compares; UsageError for an option that is idle without --fit."""
    if args.fit is not None:
        escapement: esc.Escapement = _arguments.read_escapement(args)
        return escapement
    for name in (*idle, *model_settings()):
        if getattr(args, name) is not None:
            alone = f"{option(name)} must come with --fit, got {option(name)} alone"
            raise UsageError(f"{alone}; add --fit {remedy}")
    return None
