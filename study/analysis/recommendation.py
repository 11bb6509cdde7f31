"""The table of recommended schemes and steps that an assessment gives."""

import shutil
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import pandas as pd
import xarray as xr

from study.analysis.duration import FREE
from study.registry import UnknownName, did_you_mean
from study.words import measured, number, percent, printed_unit, step_size, step_with_unit, text_of, typed

#: Columns of step sizes, which are never printed larger than they are, and columns of whole numbers.
STEP_SIZES = ("step_size", "largest_step_size", "step_size_of_runs")
WHOLE = ("steps", "force_evaluations", "steps_tried", "controlled_steps", "controlled_force_evaluations")


class Recommended(pd.DataFrame):
    """The table of :func:`study.recommend`. It is printed below the answer in words, with numbers of three digits.

    ``attrs`` holds the lines of the ``answer``; ``notes``, sentences on the error, the reference value and remarks; and
    ``spacing``, the time between samples of a record in s.
    """

    @property
    def _constructor(self) -> Callable[..., pd.DataFrame]:
        return Recommended

    def _formatted(self) -> pd.DataFrame:
        """The table as text."""
        forms: dict[object, Callable] = dict.fromkeys(WHOLE, lambda x: typed(x, 15))
        forms |= dict.fromkeys(STEP_SIZES, partial(step_size, spacing=self.attrs.get("spacing")))

        def printed(value, form):
            return form(value) if isinstance(value, float | int) and not isinstance(value, bool) else value

        columns = [column.map(lambda x, name=name: printed(x, forms.get(name, typed))) for name, column in self.items()]
        return pd.DataFrame(dict(enumerate(columns)), index=self.index).set_axis(self.columns, axis=1)

    def to_string(self, *arguments, **options):  # type: ignore[override]
        """The answer and the table as text; the parameters are those of pandas."""
        table = self._formatted().to_string(*arguments, **options)
        return table if table is None else "\n".join([*self._words(), table]).replace("\u00a0", " ")

    def __repr__(self) -> str:
        """The answer and all columns of the table, in blocks that fit the width of the terminal."""
        return self.to_string(line_width=shutil.get_terminal_size().columns)

    def _repr_html_(self) -> str | None:
        table = self._formatted()._repr_html_()  # type: ignore[operator]
        return table if table is None else "".join(f"<p>{text_of(line)}</p>" for line in self._words()) + table

    def _words(self) -> list[str]:
        return [*self.attrs.get("answer", ()), *self.attrs.get("notes", ())]


#: Where the allowed errors of the study's own runs are set.
SECTION = "the section runs of the configuration"


def chosen(
    dataset: xr.Dataset, quantities: Sequence[str], error: float, quantity: str | None
) -> tuple[str, xr.Dataset]:
    """The quantity, by default the first of ``quantities``, and the part of a dataset for it and an allowed error.

    Raises
    ------
    KeyError
        If ``quantity`` is not among the quantities.
    ValueError
        If ``error`` is not among the allowed errors of the dataset.
    """
    quantity = quantities[0] if quantity is None else quantity
    if quantity not in quantities:
        raise UnknownName(f"no step was sought for the quantity {quantity!r}; {did_you_mean(quantity, quantities)}")
    limits = dataset.allowed_error.values
    if not np.isclose(limits, error, rtol=1e-9, atol=0).any():
        raise ValueError(
            f"allowed_error must be one that was assessed, {', '.join(f'{x:g}' for x in limits)}, not {error:g}; "
            f"allowed_errors of {'study.assess' if 'recommended_step_size' in dataset else SECTION} sets others."
        )
    return quantity, dataset.sel(quantity=quantity).sel(allowed_error=error, method="nearest")


def table_of_assessment(assessed: xr.Dataset, error: float, quantity: str | None = None) -> pd.DataFrame:
    """The table of :func:`study.recommend` for a dataset of :func:`study.assess`."""
    if "recommended_step_size" not in assessed:
        raise ValueError(
            "recommend takes a dataset of study.assess, or the needs of one problem, such as "
            "study.open_dataset('needs').sel(problem='softening')."
        )
    quantity, answers = chosen(assessed, assessed.quantity.values.tolist(), error, quantity)
    words = np.array([word.replace("_", " ") for word in answers.verdict.flag_meanings.split()])
    steps = np.floor(assessed.attrs["duration"] / answers.recommended_step_size * (1 + 1e-9))
    recommended = answers.recommended_step_size.dropna("scheme").reset_coords(drop=True)
    errors = assessed.error.sel(scheme=recommended.scheme, step_size=recommended).to_pandas()
    table = pd.DataFrame(
        {
            "kind": answers.kind,
            "step_size": answers.recommended_step_size,
            "largest_step_size": answers.largest_step_size,
            "omega_step": answers.recommended_step_size * assessed.highest_frequency.item(),
            "steps": steps,
            "error": answers.recommended_error,
            "seconds": answers.seconds,
            "seconds_spread": answers.seconds_spread,
            "force_evaluations": answers.force_evaluations,
            "force_evaluations_per_time": answers.force_evaluations / (steps * answers.recommended_step_size),
            "steps_tried": answers.steps_tried,
            "largest_error": answers.largest_error,
            "verdict": words[answers.verdict.values],
        },
        index=pd.Index(answers.scheme.values, name="scheme"),
    )
    ties = _ties(table) & table["seconds"].notna()
    table.insert(table.columns.get_loc("seconds_spread") + 1, "ties_with_fastest", ties)
    table = table.loc[_ranked(table)]
    if "tolerance" in assessed:
        table["tolerance"] = answers.tolerance.to_series()
        table["controlled_force_evaluations"] = answers.controlled_force_evaluations.to_series()
        table["control_over_equal"] = table["controlled_force_evaluations"] / table["force_evaluations"]
    table.insert(table.columns.get_loc("error") + 1, "most_wrong", errors.idxmax(axis=1))
    table.insert(table.columns.get_loc("most_wrong") + 1, "most_wrong_error", errors.max(axis=1))
    recommendation = Recommended(table)
    scope = f"{percent(error)} of {quantity}"
    requested = _requested_answers(assessed, table, scope)
    answer = [*requested, answer_line(assessed, table, f"{scope}, best" if requested else scope)]
    recommendation.attrs = {
        "quantity": quantity,
        "spacing": assessed.attrs.get("spacing"),
        "answer": answer,
        "notes": _notes(assessed, answers, stated=answer),
    }
    return recommendation


def costs_of(table: pd.DataFrame) -> pd.Series:
    """Number of forces of each scheme, or of steps if forces are not counted for all."""
    forces = table["force_evaluations"][table["step_size"].notna()]
    return table["force_evaluations"] if forces.notna().all() else table["steps"]


def _ties(table: pd.DataFrame) -> pd.Series:
    """Whether the time of each scheme differs from the shortest one by less than the spread of both.

    If no scheme has a time, all tie.
    """
    seconds = table["seconds"].fillna(np.inf)
    fastest = table.loc[seconds.idxmin()]
    spread = (table["seconds_spread"] + fastest.seconds_spread) / 2
    return ~(seconds - fastest.seconds > spread.fillna(0.0))


def _ranked(table: pd.DataFrame) -> list:
    """Names of the schemes, the fastest first.

    Among the schemes that tie with the fastest one of those left, the number of forces or steps decides, and at equal
    numbers the error.
    """
    remaining, ranked = table.assign(count=costs_of(table)).sort_values("seconds", kind="stable"), list[object]()
    while len(remaining):
        ranked.append(remaining[_ties(remaining)].sort_values(["count", "error"], kind="stable").index[0])
        remaining = remaining.drop(ranked[-1])
    return ranked


def over_duration(
    table: Recommended,
    titles: pd.Series,
    law: pd.Series,
    step_size: pd.Series,
    error: float,
    known: float,
    duration: float,
) -> Recommended:
    """The table for a longer duration than that of the runs, with steps by the law of :mod:`study.analysis.duration`.

    Parameters
    ----------
    table
        Table with the columns ``kind``, ``step_size``, ``omega_step`` and ``force_evaluations_per_time`` of runs over
        ``known``.
    titles, law
        Titles of the schemes, and the exponents with which their steps fall.
    step_size
        Steps for the longer duration, the schemes in the order of the result; NaN without one.
    known, duration
        Durations in s.
    """
    table, law = table.loc[step_size.index], law[step_size.index]
    finer = step_size / table.step_size
    longer = Recommended(
        {
            "kind": table.kind,
            "step_size": step_size,
            "omega_step": table.omega_step * finer,
            "steps": np.ceil(duration / step_size * (1 - 1e-9)),
            "force_evaluations": table.force_evaluations_per_time / finer * duration,
            "exponent": law,
            "step_size_of_runs": table.step_size,
            "verdict": np.where(step_size.notna(), "extrapolated", table.verdict),
        }
    )
    longer.attrs = {
        "answer": [
            f"{percent(error)} of {table.attrs['quantity']} over {number(duration)} s, {row.kind}: {titles[name]}, "
            f"{step_with_unit(row.step_size)} (extrapolated)"
            for name, row in firsts(longer).iterrows()
        ],
        "notes": [
            f"Steps are extrapolated from runs over {number(known)} s by Δt ∝ n^(−exponent), with the number n of "
            f"periods. No run of {number(duration)} s confirms them. The law holds for {FREE}, not for chaotic motion."
        ],
    }
    return longer


def answer_line(assessed: xr.Dataset, table: pd.DataFrame, scope: str) -> str:
    """The answer on one line: allowed error, scheme and step, such as ``1 % of displacement: Bathe, 5 ms``."""
    best = table.iloc[0]
    if not best.step_size > 0:
        return f"{scope}: no scheme was found ({', '.join(sorted(set(table.verdict)))})"
    return f"{scope}: {best_of(assessed, best)}"


def best_of(assessed: xr.Dataset, row: pd.Series) -> str:
    """Scheme and step of a row of the table, such as ``Bathe, 5 ms``."""
    title = assessed.scheme_title.sel(scheme=row.name).item()
    return f"{title}, {step_with_unit(row.step_size, assessed.attrs.get('spacing'))}"


def firsts(table: pd.DataFrame) -> pd.DataFrame:
    """The first row of each kind of scheme that has a step."""
    return table[table["step_size"] > 0].groupby("kind", sort=False).head(1)


def asked_for(assessed: xr.Dataset) -> list[str]:
    """Names of your own schemes, for which the assessment was asked."""
    return [name for name in assessed.attrs.get("asked_for", "").split("; ") if name in assessed.scheme.values]


def own_scheme_answer(assessed: xr.Dataset, table: pd.DataFrame, name: str) -> str:
    """The step of your own scheme, and the ratio of its cost to the least cost of the others; or why it has none."""
    if not table.step_size[name] > 0:
        return f"no step was found ({table.verdict[name]})"
    counts, requested = costs_of(table), asked_for(assessed)
    competitors = counts[[name for name in table.index if name not in requested and table.step_size[name] > 0]].dropna()
    step = step_with_unit(table.step_size[name], assessed.attrs.get("spacing"))
    if competitors.empty:
        return step
    title = assessed.scheme_title.sel(scheme=competitors.idxmin()).item()
    counted = "forces" if counts.name == "force_evaluations" else "steps"
    return f"{step}, {number(counts[name] / competitors.min(), 2)} × the {counted} of {title}"


def controller_answer(assessed: xr.Dataset, table: pd.DataFrame) -> tuple[str, str]:
    """Scheme and tolerance with the fewest forces, and the ratio of these to those of equal steps, if known."""
    controlled = table["controlled_force_evaluations"].dropna()
    if controlled.empty:
        return "no tolerance was found", ""
    row = table.loc[controlled.idxmin()]
    title = assessed.scheme_title.sel(scheme=row.name).item()
    ratio = f"{number(row.control_over_equal, 2)} ×" if row.control_over_equal > 0 else ""
    return f"{title}, tolerance {typed(row.tolerance)}", ratio


def _requested_answers(assessed: xr.Dataset, table: pd.DataFrame, scope: str) -> list[str]:
    """Sentences on your own schemes and on the controller that were asked for."""
    titles, sentences = assessed.scheme_title.to_series(), list[str]()
    remarks = assessed.attrs.get("remarks", "").split("; ")
    for name in asked_for(assessed):
        sentences += [remark for remark in remarks if remark.startswith(f"{titles[name]} is")]
        sentences.append(f"{scope}, {titles[name]}: {own_scheme_answer(assessed, table, name)}")
    if "tolerance" in table:
        controller = assessed.attrs["controller"]
        words, ratio = controller_answer(assessed, table)
        ending = f", {ratio} the forces of equal steps" if ratio else ""
        sentences.append(f"{scope}, controlled steps ({controller}): {words}{ending}")
    return sentences


def _notes(assessed: xr.Dataset, values: xr.Dataset, stated: Sequence[str]) -> list[str]:
    """The scale of the errors, the reference value, and the remarks on the quantity that are not ``stated`` yet."""
    name = values.quantity.item()
    notes = [f"Errors of {name} are {values.relative_to.item()}."] if "relative_to" in values.coords else []
    notes += [reference_value(values)] if "reference_value" in values else []
    others = [f"'{other}'" for other in assessed.quantity.values if other != name]
    remarks = [remark for remark in assessed.attrs.get("remarks", "").split("; ") if remark and remark not in stated]
    remarks = [remark for remark in remarks if not any(other in remark for other in others)]
    return notes + [f"{remark[0].upper()}{remark[1:]}." for remark in remarks]


def reference_value(values: xr.Dataset) -> str:
    """The value of a quantity in the reference, in the component where it is largest, with its uncertainty and time."""
    known = values.dropna("component", subset=["reference_value"])
    if not known.sizes["component"]:
        return f"The reference of {values.quantity.item()} has no single value."
    largest = known.isel(component=int(abs(known.reference_value).argmax("component")))
    unit = f" {printed_unit(values.quantity_units.item())}" if values.quantity_units.item() != "1" else ""
    where = f" in component {largest.component.item()}" if known.sizes["component"] > 1 else ""
    when = f" at t = {largest.reference_time.item():.4g} s" if largest.reference_time.notnull() else ""
    value, uncertainty = measured(largest.reference_value.item(), largest.reference_value_uncertainty.item())
    return f"Reference of {values.quantity.item()}: {value}{unit}{where}{when}, uncertain by {uncertainty}{unit}."
