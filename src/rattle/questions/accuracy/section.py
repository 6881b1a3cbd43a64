"""How far play lets the output of a mechanism deviate, in a report."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import MaxNLocator

from rattle.analyses.driver_period import driver_period
from rattle.pages.report_figures import HALF, STEPS, names_above, plain_ticks, with_time
from rattle.pages.report_html import Section, abreast, figure, gallery, handy, listed, paragraph, sentence, table
from rattle.pages.report_study import POSITIONS, Headline, Study, tried
from rattle.plots import curves as style
from rattle.questions.accuracy.compute import Accuracy
from rattle.questions.accuracy.pictures import draw_band, draw_deviation


def gather(study: Study) -> None:
    if not study.loose or study.run is None:
        study.reasons["accuracy"] = "no joint has play"
        return
    if not study.m.model.drivers:
        study.reasons["accuracy"] = "nothing drives the mechanism, so it has no position that play could falsify"
        return
    end = min(driver_period(study.m.system) or np.inf, study.run.trust.t_end)
    study.keep("accuracy", tried(
        study, "accuracy", "computing how far play lets the output deviate",
        lambda: study.m.accuracy(study.output, np.linspace(0.0, end, POSITIONS)),
    ))  # fmt: skip


def section(s: Study) -> Section:
    """How far play lets the output deviate."""
    answer = s.answer("accuracy", Accuracy)
    if answer is None:
        return s.left_out("Accuracy", "accuracy")
    k = int(np.argmax(answer.worst))
    total = answer.worst[k]
    when = handy(answer.t[k], "s")
    facts = [f"Worst case, every pin anywhere in its clearance: ±{handy(total, answer.unit)}, at t = {when}."]
    facts.append(f"Root sum square, if the joints vary independently: ±{handy(answer.rss[k], answer.unit)} there.")
    most = answer.share[answer.tighten]
    first = [name for name, share in answer.share.items() if share > 0.99 * most]
    if len(answer.joints) > 1:
        facts.append(f"To tighten first: {' or '.join(first)}.")
    most_of = dict(zip(answer.joints, answer.contributions[k], strict=True))
    rows = [
        (name, handy(answer.clearances[name], "m"), f"±{handy(most_of[name], answer.unit)}", f"{100 * share:.0f} %")
        for name, share in sorted(answer.share.items(), key=lambda item: -item[1])
    ]
    body = paragraph(f"How far the play lets {answer.of} deviate from its value without play.")
    shares = table(("joint", "clearance", "contribution at most", "share"), rows)
    body += abreast([listed(facts), shares]) + listed(map(sentence, answer.notes))
    return Section("Accuracy under play", body + _figures(answer))


def _figures(answer: Accuracy) -> str:
    """The output with the band that play allows, and the deviation alone."""
    band, deviation = (style.new_axes(HALF, 2.1)[0] for _ in range(2))
    draw_band(band, answer)
    draw_deviation(deviation, answer)
    for ax in (band, deviation):
        for handle in ax.get_legend_handles_labels()[0]:
            handle.set_label(str(handle.get_label()).replace(",\nfirst order", "").replace("\n", " "))
        names_above(ax)
        ax.margins(x=0.0)
        ax.xaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
        plain_ticks(ax)
    words = (f"{answer.of} with the band that play allows.", f"Deviation of {answer.of} by play.")
    return gallery([figure(with_time([ax]), caption) for ax, caption in zip((band, deviation), words, strict=True)])


def headline(s: Study) -> list[Headline]:
    """The largest deviation."""
    answer = s.answer("accuracy", Accuracy)
    if answer is None:
        return []
    return [("Deviation by play at most", f"±{handy(float(answer.worst.max()), answer.unit)}", f"of {answer.of}")]


SECTIONS = ((90, section),)
