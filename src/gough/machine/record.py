"""How a recorded log of a machine is written: its columns, their units, and what may be missing.

    schema = "gough-log-map-1"          in a file of its own; or the table [record] of a data sheet
    [time]    column = "t"  unit = "s"  period = "1 ms"
    [joints]  columns = ["q1", "q2"]    unit = "mm"                         what the encoders read
    [forces]  columns = ["i1", "i2"]    unit = "A"  factor = "0.6 N m"      what the drives gave
    [text]    delimiter = ";"  decimal = ","                                of CSV
    [gaps]    longest = "5 ms"  most = "1 %"                                what may be missing
    [identify] cutoff = "100 Hz"  friction = ["coulomb", "offset"]          of gough identify, where nothing is said

`factor` is the force or the motor torque that one of `unit` stands for; without it `unit` is itself one of either.  A
torque becomes a force by the lead of the machine's screws.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, LogError
from ..units import parse, same_dimension, unit

SCHEMA = "gough-log-map-1"
_NAME = Field(max_length=200, min_length=1)
_FORCE, _TORQUE, _LENGTH, _TIME = (unit(text)[1] for text in ("N", "N m", "m", "s"))


class Time(Part):
    """When the rows were taken."""

    input_error = LogError

    period: float = quantity("s", "time from sample to sample", theta=False, above=0, at_most=10)
    column: str | None = Field(None, max_length=200, description="time of each row; left out: every row is a sample")
    unit: str = Field("s", description='of the column; "samples" for a counter')
    jitter: float | None = quantity(
        "s", "how far from its sample's time a row may lie; a quarter of the period where left out", default=None,
        theta=False, at_least=0,
    )  # fmt: skip

    @model_validator(mode="after")
    def _known(self):
        if self.unit != "samples" and unit(self.unit)[1] != _TIME:
            raise InputError("is not a unit of time", key="unit", value=repr(self.unit), cure='write "s" or "samples"')
        if self.jitter is not None and self.jitter >= self.period / 2:
            raise InputError("must be below half the period", key="jitter", value=f"{self.jitter:g} s")
        return self

    @property
    def scale(self) -> float:
        """Seconds of one `unit`."""
        return self.period if self.unit == "samples" else unit(self.unit)[0]

    @property
    def allowed(self) -> float:
        """s, how far from its sample a row may lie."""
        return self.period / 4 if self.jitter is None else self.jitter


class Columns(Part):
    """Columns of one kind, one for each joint in the machine's order."""

    input_error = LogError
    dimensions: ClassVar[tuple] = (_LENGTH,)
    meant: ClassVar[str] = "a length"
    example: ClassVar[str] = "mm"

    columns: list[str] = Field(min_length=1, max_length=64, description="names, in the order of the joints")
    unit: str = Field(min_length=1, max_length=20)
    factor: str | None = Field(None, max_length=64, description="what one of `unit` stands for, as a quantity")
    sign: float | Array = quantity("1", "1 or -1: the machine's direction", default=1.0, theta=False, shape=(-1,))

    @model_validator(mode="after")
    def _known(self):
        self.scale_and_dimension()  # raises
        if not np.isin(self.sign, (1.0, -1.0)).all():
            raise InputError("must be 1 or -1", key="sign", value=str(np.ravel(self.sign).tolist()))
        if np.ndim(self.sign) and len(self.sign) != len(self.columns):
            raise InputError("needs one value or one a column", key="sign", value=str(len(self.sign)))
        twice = sorted({name for name in self.columns if self.columns.count(name) > 1})
        if twice:
            raise InputError("a column is named twice", key="columns", value=repr(twice[0]))
        return self

    def scale_and_dimension(self) -> tuple[float, Any]:
        """SI value of one of the column's unit, and its dimension.

        Raises
        ------
        InputError
            neither `factor` nor `unit` is of the right kind.
        """
        if self.factor is not None:
            scale, dimension = parse(self.factor)
            key, value = "factor", self.factor
            if scale == 0:
                raise InputError("must not be 0", key="factor", value=self.factor)
        else:
            try:
                scale, dimension = unit(self.unit)
            except InputError:
                cure = f'give factor = "... {self.example}", what 1 {self.unit} stands for'
                raise InputError("is no unit that gough knows", key="unit", value=repr(self.unit), cure=cure) from None
            key, value = "unit", self.unit
        if not any(same_dimension(dimension, known) for known in self.dimensions):
            cure = f'give factor = "... {self.example}", what 1 {self.unit} stands for'
            raise InputError(f"is not {self.meant}", key=key, value=repr(value), cure=cure)
        return scale, dimension


class Readings(Columns):
    """What the encoders read."""

    offset: float | Array = quantity(
        "m", "added to the readings: where the machine counts from", default=0.0, theta=False, shape=(-1,)
    )


class Forces(Columns):
    """What the drives gave."""

    dimensions: ClassVar[tuple] = (_FORCE, _TORQUE)
    meant: ClassVar[str] = "a force or a torque"
    example: ClassVar[str] = "N m"

    clip: float | None = quantity(
        "1", "in the column's own unit: at or beyond it the record is cut off", default=None, theta=False, above=0
    )
    acts: Literal["after", "before"] = Field("after", description="a row's force acts after its readings, or before")

    def factor_of(self, machine) -> float:
        """N of one of the column's unit, on the joints of `machine`.

        Raises
        ------
        LogError
            torques, on a machine without screws.
        """
        scale, dimension = self.scale_and_dimension()
        if same_dimension(dimension, _FORCE):
            return scale
        lead = getattr(machine.drive, "lead", None)
        if lead is None:
            raise LogError(
                "a torque is no force on a machine without screws", key="record.forces",
                value=self.factor or self.unit, cure='give factor = "... N"',
            )  # fmt: skip
        return scale * 2 * np.pi / lead


class Text(Part):
    """How a text file is written."""

    input_error = LogError

    delimiter: Literal[",", ";", "\t", " ", "|"] = ","
    decimal: Literal[".", ","] = "."
    header: int = Field(1, ge=0, le=100, description="lines up to and with the names; 0: columns are numbered from 1")
    skip: list[str] = Field(default=["#"], max_length=20, description="lines that begin so are no samples")

    @model_validator(mode="after")
    def _apart(self):
        if self.decimal == self.delimiter:
            raise InputError(
                "delimiter and decimal must differ", key="decimal", value=repr(self.decimal),
                cure='write delimiter = ";" beside decimal = ","',
            )  # fmt: skip
        return self


class Gaps(Part):
    """What may be missing, and is held, told and left out."""

    input_error = LogError

    longest: float = quantity(
        "s", "cells that are empty, no number or cut off, up to so long a time", default=0.0, theta=False, at_least=0
    )
    most: float = quantity("1", "share of samples that may be missing", default=0.01, theta=False, at_least=0, below=1)


class Identify(Part):
    """What identification takes of this record where the command says nothing."""

    input_error = LogError

    cutoff: float | None = quantity("Hz", "of the low-pass filter", default=None, theta=False, above=0)
    friction: list[str] | None = Field(None, max_length=10, description="kinds of friction that are estimated")


class RecordMap(Part):
    """How a record is written."""

    input_error = LogError

    time: Time
    joints: Readings
    forces: Forces
    text: Text = Text()
    gaps: Gaps = Gaps()
    identify: Identify = Identify()
    machine: str | None = Field(None, max_length=64, description="name of the machine that the record is of")

    @model_validator(mode="after")
    def _one_each(self):
        if len(self.joints.columns) != len(self.forces.columns):
            raise InputError(
                "as many forces as readings are needed", key="forces.columns", value=str(len(self.forces.columns)),
                limit=str(len(self.joints.columns)),
            )  # fmt: skip
        both = [name for name in self.names if self.names.count(name) > 1]
        if both:
            raise InputError("one column is given two meanings", key="forces.columns", value=repr(both[0]))
        return self

    @property
    def names(self) -> list[str]:
        """All columns that are read: readings, forces, time."""
        time = [] if self.time.column is None else [self.time.column]
        return [*self.joints.columns, *self.forces.columns, *time]

    def fits(self, machine) -> RecordMap:
        """This map, if it has a column for each joint of `machine`.

        Raises
        ------
        LogError
            it has not, or torques meet a machine without screws.
        """
        if len(self.joints.columns) != machine.joints_count:
            raise LogError(
                f"{machine.name} has {machine.joints_count} joints", key="joints.columns",
                value=f"{len(self.joints.columns)} columns", cure="name one for each joint, in its order",
            )  # fmt: skip
        self.forces.factor_of(machine)
        return self
