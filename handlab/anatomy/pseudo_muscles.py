"""Records of the 42 pseudo muscles of Table 1. Lengths in metres."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LeverArm:
    """One row of Table 1: signed lever arm of a muscle at a degree of freedom, in metres.

    ``used`` is the default reading, ``printed`` the reading ``printed``; ``reason`` says why they differ.
    ``printed_basis``: "printed", "analogous", "printed at another joint" (then ``printed`` is 0 here)
    or "not printed, used value".
    """

    dof: str
    used: float
    printed: float
    printed_as: str | None
    printed_basis: str
    status: str
    reason: str | None
    confidence: str
    sources: tuple[str, ...]
    remark: str | None = None
    assumption: bool = False


@dataclass(frozen=True)
class Muscle:
    """One pseudo muscle of Table 1.

    ``rest_length`` is the default reading and ``rest_length_printed`` the reading ``printed``, both in metres;
    ``rest_length_basis`` is "printed" or "not printed, used value". ``paralysed_in`` names lesions like ``high_median``.
    """

    name: str
    abbreviation: str
    latin: str
    group: str
    region: str
    rest_length: float
    rest_length_printed: float
    rest_length_basis: str
    rest_length_source: str
    tension_percent: float
    tension_source: str
    nerve: str
    branch: str
    roots: str
    paralysed_in: tuple[str, ...]
    partially_paralysed_in: tuple[str, ...]
    action: str
    origin: str
    insertion: str
    lever_arms: tuple[LeverArm, ...]
    remarks: tuple[str, ...] = ()
    also_called: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return muscle_table(self)


def muscle_table(muscle: Muscle) -> str:
    """The muscle as a small table with units and sources."""
    other = "" if muscle.rest_length_printed == muscle.rest_length else f" (printed {muscle.rest_length_printed * 1000:.1f} mm)"
    lines = [
        f"{muscle.name} ({muscle.abbreviation}), {muscle.group}, {muscle.region}",
        f"  rest length      {muscle.rest_length * 1000:6.1f} mm   [{muscle.rest_length_source}]{other}",
        f"  tension fraction {muscle.tension_percent:6.1f} %    [{muscle.tension_source}]",
        f"  nerve            {muscle.nerve} ({muscle.roots})",
        f"  origin           {muscle.origin}",
        f"  insertion        {muscle.insertion}",
        f"  action           {muscle.action}",
        "  lever arm                        used mm  printed mm  source",
    ]
    lines += [
        f"    {arm.dof:<30} {arm.used * 1000:+7.1f}  {arm.printed * 1000:+9.1f}   {', '.join(arm.sources)} ({arm.status})"
        for arm in muscle.lever_arms
    ]
    return "\n".join(lines)
