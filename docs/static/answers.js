// The scheme and the step for a model, an error, a duration, a kind of scheme and a program, from the needs of all schemes.
const form = document.getElementById("answers");
if (form) {
  const needs = JSON.parse(document.getElementById("needs").textContent);
  const {model, quantity, error, periods, kind, code} = form.elements;

  const fill = (select, options, chosen) => {
    select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
    if (options.some(([value]) => `${value}` === `${chosen}`)) select.value = chosen;
  };
  const element = (name, text) => Object.assign(document.createElement(name), {textContent: text});

  const rowsOf = () => needs.rows.filter(([p, q, e]) => p === +model.value && q === +quantity.value && e === +error.value);
  // the law of study/analysis/duration.py: over n periods the step falls with n^(-a), and a shorter duration keeps it;
  // null if no law is known
  const factor = (row) => {
    const problem = needs.problems[model.value];
    if (problem.records || !(periods.value > problem.decided)) return 1;
    return row[9] === null ? null : (periods.value / problem.decided) ** row[9];
  };
  const cost = (row) => row[10] * factor(row);
  // names and inputs of the chosen programs for a scheme
  const inputs = (scheme) => Object.entries(scheme.codes).filter(([name]) =>
    code.value === "codes" ? needs.programs.some((program) => name.startsWith(program)) : name === code.value);

  // the cheapest scheme; among ties the one with the smallest error
  const decide = (rows) => {
    const least = Math.min(...rows.map(cost));
    return rows.filter((row) => cost(row) <= needs.tied * least).reduce((best, row) => (row[8] < best[8] ? row : best));
  };
  const ranked = (rows) => {
    const left = [...rows], order = [];
    while (left.length) order.push(...left.splice(left.indexOf(decide(left)), 1));
    return order;
  };

  const roundedUp = (number) => {
    const unit = Math.max(10 ** (Math.floor(Math.log10(number)) - 2), 1);
    return Number((Math.ceil(number / unit - 1e-9) * unit).toPrecision(12));
  };
  const steps = (row) => {
    const finer = factor(row);
    if (finer === 1) return [row[4], row[6]];
    return [`about ${roundedUp(row[5] * finer).toLocaleString("en")}`, `${Number((row[6] / finer).toPrecision(2))}`];
  };

  const quantities = () => {
    const known = new Set(needs.rows.filter(([p]) => p === +model.value).map((row) => row[1]));
    const names = ["displacement", "peak drift"].map((name) => needs.quantities.indexOf(name));
    fill(quantity, [...known].sort((a, b) => names.includes(b) - names.includes(a) || a - b)
      .map((q) => [q, needs.quantities[q]]), quantity.value);
    const problem = needs.problems[model.value];
    periods.value = problem.records ? "" : problem.decided;
    periods.disabled = problem.records;
  };

  const show = () => {
    const problem = needs.problems[model.value], parts = [];
    if (!problem.records && !(periods.value > 0)) {
      document.getElementById("answer").replaceChildren(element("p", "Give the duration as a number of periods above zero."));
      return;
    }
    const admitted = rowsOf().filter((row) => {
      const scheme = needs.schemes[row[3]];
      return (!kind.value || scheme.explicit === (kind.value === "explicit")) && (!code.value || inputs(scheme).length);
    });
    if (admitted.some((row) => factor(row) === null)) {
      document.getElementById("answer").replaceChildren(element("p", `No step is known over ${periods.value} periods: the ` +
        `runs last ${problem.decided}, and no law extends them. Assess your own model.`));
      return;
    }
    const groups = [true, false].map((explicit) =>
      ranked(admitted.filter((row) => needs.schemes[row[3]].explicit === explicit))).filter((group) => group.length);
    const first = groups.length && decide(groups.map(([best]) => best));
    groups.sort((a, b) => (b[0] === first) - (a[0] === first));
    for (const [best] of groups) {
      const scheme = needs.schemes[best[3]], [step, omega] = steps(best);
      const counted = problem.records ? step : `${step} steps in a period`;
      const line = element("p", "");
      line.append(element("b", `${scheme.title}: ${counted}`), `, ωΔt = ${omega}, `,
        scheme.explicit ? "explicit" : "implicit", best[11] ? " (the whole motion needs another step)" : "");
      for (const [name, input] of inputs(scheme)) line.append(`; ${name} `, element("code", input));
      parts.push(line);
    }
    if (!groups.length) parts.push(element("p", "No step tried keeps this error with a scheme of this kind and program."));
    parts.push(element("p", `Measured on: ${problem.title}, ${problem.unknowns} unknown${problem.unknowns > 1 ? "s" : ""}, ` +
      (problem.records ? `each run ${problem.duration} s long; ω of the shortest period. ` :
        `period T = ${problem.scale} s, highest ω = ${problem.omega} /s, ${problem.decided} T. `) +
      (!problem.records && periods.value > problem.decided ?
        "The step for the longer duration follows from a law of free vibration; it was not run." : "")));
    const table = document.createElement("table"), body = table.createTBody();
    const head = table.createTHead().insertRow();
    const timed = problem.timed ? ["computing time in a second"] : [];
    for (const name of ["scheme", "kind", problem.records ? "step" : "steps in T", "ωΔt", "forces in a second", ...timed])
      head.append(element("th", name));
    for (const row of groups.flat()) {
      const line = body.insertRow(), [step, omega] = steps(row), scheme = needs.schemes[row[3]];
      for (const text of [scheme.title + (row[11] ? " ‡" : ""), scheme.explicit ? "explicit" : "implicit", step, omega,
        Number((row[7] * factor(row)).toPrecision(3)).toLocaleString("en"),
        ...timed.map(() => `${Number((1e3 * cost(row)).toPrecision(2))} ms`)]) line.append(element("td", text));
    }
    const scroll = element("div", "");
    scroll.className = "wide";
    scroll.append(table);
    if (groups.length) parts.push(scroll);
    if (groups.flat().some((row) => row[11]))
      parts.push(element("p", "‡ The whole motion, with displacement, velocity, acceleration and energy, needs another step."));
    document.getElementById("answer").replaceChildren(...parts);
  };

  fill(model, needs.problems.map(({title}, p) => [p, title]),
    needs.problems.findIndex((problem) => problem.model === needs.first.model));
  fill(error, needs.errors.map((name, e) => [e, name]), needs.errors.indexOf(needs.first.error));
  fill(code, [["codes", `${needs.programs.slice(0, -1).join(", ")} or ${needs.programs.at(-1)}`],
    ["", "any program or paper"], ...needs.codes.map((name) => [name, name])]);
  quantities();
  form.hidden = false;
  form.addEventListener("input", (event) => {
    if (event.target === model) quantities();
    show();
  });
  form.addEventListener("submit", (event) => event.preventDefault());
  show();
}
