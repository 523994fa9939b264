"""The gap benchmark's report: report.md with two plots, figures beside the aims."""

from __future__ import annotations

from pathlib import Path

HOW = """\
Cells with true effects, drawn by `tests/bench/gap/maker.py` from a simulator that shares no code with camrob (its own product
of exponentials of the KR15 cell on a track with a turntable; effects richer than the library's: play with state on a 4 ms
grid, a lag that steps once a cycle, Stribeck friction, Denavit-Hartenberg tolerances, growth of every link, a ripple that is
no pure sine). Two in five draws of an effect follow another physics of the same name: a lag of each axis's own, friction
without Stribeck's peak, a pedestal that grows, lean by reach, a track that sags, an axis's own give under acceleration, an
eccentric encoder, a spring at the tip. Every case has two runs of one cell: rasters, tours of circles or space curves of 25
to 100 s at 10 to 62.5 Hz, and another such path of 20 to 40 s, so at another speed, that takes no part in choosing or
fitting; or 80 to 260 single poses and as many others (12 %). 20 % are position-only, 10 % lack encoders, 10 % lack
set-points, 15 % are measured on the turning table, 15 % of the paths don't tell the instrument's noise, half of the paths
have 1 % outliers of 1 mm. Noise 0.01 to 0.04 mm an axis. Effects move the TCP by 0.5 to 20 times the noise's rms
(log-uniform, and no value beyond what machines have; 1.5 to 20 times outside the library); nuisances of all other effects
together move it by 0 to 0.1 times the noise on either run and count as nothing. `corner_rounding` is not drawn: it lies
between program and set-point and is tested apart. Labels are written to a folder of their own, which no diagnosis is told of,
and opened by the scorer.

"Up to its group": the path can't separate what was said from the truth. The scorer simulates what all parameters of the
claimed effects can show on the logged channels; the true effect's pattern lies within {limit:g} degrees of that (and no more
names than true ones are said). Where the true effect isn't in the library, "looks the same" is that angle to all that is
claimed. Intervals are 95 % (Wilson), the bound on false alarms is one-sided (Clopper and Pearson).
"""


def percent(record):
    """A share in words."""
    if not record or record["share"] is None:
        return "no case"
    low, high = record["interval"]
    return f"{100 * record['share']:.1f} % ({100 * low:.0f} to {100 * high:.0f}; {record['hits']} of {record['count']})"


def _headline(f):
    one, alarms, out = f["one effect at >= 2x noise"], f["false alarms"], f["outside the library"]
    two, three, removed = f["two effects"], f["three effects"], f["removable gap removed on the withheld run"]
    off, size, seconds = f["predicted less reached shrinkage, points"], f["size of the reported set"], f["seconds"]

    def number(x, digits=2):
        return "-" if x is None else f"{x:.{digits}f}"

    removable = "-"
    if removed["median"] is not None:
        removable = (
            f"{100 * removed['median']:.1f} %; {100 * removed['10th percentile']:.1f} % ({removed['cases']} cases)"
        )
    took = f"{seconds['median']:.1f}; {seconds['95 %']:.1f}; {seconds['worst']:.1f}"
    rows = f"median of {seconds['rows, median']:.0f} rows, at most {seconds['rows, most']:.0f}"
    errors = [number(f[f"calibration of {kind}"]["error"], 3) for kind in ("sets", "effects")]
    any_size = "; ".join(percent(x) for x in f["one effect, any size"].values())
    bound = f"; upper bound {100 * alarms['upper 95 % bound']:.1f} %"
    aims = {"recall": "95 %", "precision": "93 %", "exact": "85 %"}
    return [
        ("false alarms on no-effect data", "at most 1 %", percent(alarms) + bound),
        ("one effect at twice the noise or more: right first", "95 %", percent(one["right first"])),
        ("... up to its group", "99 %", percent(one["right first, up to its group"])),
        ("one effect of any size: exact; up to its group", "-", any_size),
        ("truth in the reported set (up to groups)", "98 %", percent(f["truth in the reported set"])),
        ("... by name", "-", percent(f["truth in the reported set, by name"])),
        ("mean size of the reported set: groups; names", "1.5", f"{number(size['groups'])}; {number(size['names'])}"),
        *[(f"two effects: {k}", aims.get(k, "-"), percent(v)) for k, v in two.items()],
        *[(f"three effects: {k}", "-", percent(v)) for k, v in three.items()],
        ("outside the library: flagged", "90 %", percent(out["flagged"])),
        (
            "... flagged, or said to be what looks the same",
            "-",
            percent(out["flagged, or what the path can't separate"]),
        ),
        ("... a name above 0.8", "none", percent(out["one name above 0.8"])),
        (
            "... a name above 0.8, nor does it look the same",
            "none",
            percent(out["one name above 0.8 that the path could separate"]),
        ),
        *[
            (f"... place right: {k}", "90 %" if k == "all three" else "-", percent(v))
            for k, v in out["place right"].items()
        ],
        ("false unknowns", "at most 5 %", percent(f["false unknowns"])),
        ("calibration error: sets; effects", "0.05", "; ".join(errors)),
        ("removable gap removed on the withheld run: median; 10th percentile", "97 %; -", removable),
        ("predicted shrinkage within 5 points of reached", "90 %", percent(off["within 5"])),
        *[(f"localised: {k}", "-", percent(v)) for k, v in f["localised"].items()],
        ("seconds of one core: median; 95 %; worst", "5", f"{took} ({rows})"),
    ]


def _table(head, rows):
    return [
        "| " + " | ".join(head) + " |",
        "|" + " --- |" * len(head),
        *("| " + " | ".join(r) + " |" for r in rows),
        "",
    ]


def _short(record):
    return "-" if not record or not record["count"] else f"{record['hits']} of {record['count']}"


def _plots(figures, folder: Path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    fig, axes = plt.subplots(1, 2, figsize=(10, 4.2))
    for name, colour in (("sets", "#1b6ca8"), ("effects", "#c4572d")):
        curve = figures[f"calibration of {name}"]["curve"]
        axes[0].plot([c[0] for c in curve], [c[1] for c in curve], "o-", color=colour, label=name)
        for said, true, count in curve:
            axes[0].annotate(
                str(count), (said, true), fontsize=7, xytext=(3, 4), textcoords="offset points", color=colour
            )
    axes[0].plot([0, 1], [0, 1], ":", color="grey")
    axes[0].set(
        xlabel="probability said", ylabel="share true", title="Calibration (number of answers beside the points)"
    )
    axes[0].legend()
    bands = list(next(iter(figures["found, by effect and size"].values()), {}))
    sums = [[d[b] for d in figures["found, by effect and size"].values()] for b in bands]
    share = [sum(r["hits"] for r in s) / max(1, sum(r["count"] for r in s)) for s in sums]
    axes[1].bar(bands, share, color="#1b6ca8")
    for k, s in enumerate(sums):
        axes[1].annotate(str(sum(r["count"] for r in s)), (k, share[k]), ha="center", va="bottom", fontsize=8)
    axes[1].set(
        xlabel="size of the effect, times the noise",
        ylabel="share claimed by name",
        ylim=(0, 1.08),
        title="Found, by size",
    )
    fig.tight_layout()
    fig.savefig(folder / "calibration.png", dpi=110)
    plt.close(fig)
    rows = list(figures["confusion"])
    names = sorted(
        {n for d in figures["confusion"].values() for n in d},
        key=lambda n: (n not in rows, rows.index(n) if n in rows else 0, n),
    )
    table = np.array([[figures["confusion"][r].get(n, 0) for n in names] for r in rows], float)
    fig, ax = plt.subplots(figsize=(9, 8.5))
    ax.imshow(table / np.maximum(table.sum(axis=1, keepdims=True), 1), cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for i, j in zip(*np.nonzero(table), strict=True):
        ax.text(
            j,
            i,
            f"{table[i, j]:.0f}",
            ha="center",
            va="center",
            fontsize=7,
            color="black" if table[i, j] < 0.6 * table[i].sum() else "white",
        )
    ax.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=8)
    ax.set_yticks(range(len(rows)), rows, fontsize=8)
    ax.set(
        xlabel="said first (claimed)",
        ylabel="truth (no effect, one effect, one outside the library)",
        title="Confusion",
    )
    fig.tight_layout()
    fig.savefig(folder / "confusion.png", dpi=110)
    plt.close(fig)


def write_report(figures, folder: Path, preface: str = ""):
    """Write report.md, calibration.png and confusion.png."""
    from gap.separable import LIMIT

    counts = figures["cases"]
    lines = [
        "# Sealed benchmark of `camrob diagnose`",
        "",
        *([preface.strip(), ""] if preface else []),
        HOW.format(limit=LIMIT),
    ]
    lines += [
        f"Cases: {', '.join(f'{k} {v}' for k, v in counts.items())}. SHA-256 of the labels: `{figures['sha256 of the labels']}`.",
        "",
    ]
    lines += _table(("measure", "aim", "reached"), _headline(figures))
    lines += [
        "![calibration](calibration.png)",
        "",
        "## Found, by effect and size (times the noise), in cases of one to three effects",
        "",
    ]
    bands = list(next(iter(figures["found, by effect and size"].values()), {}))
    lines += _table(
        ("effect", *bands),
        [(n, *(_short(d[b]) for b in bands)) for n, d in figures["found, by effect and size"].items()],
    )
    lines += ["## Confusion: what leads among the claims", "", "![confusion](confusion.png)", ""]
    if figures["each alone at twice the noise"]:
        lines += ["## Every effect alone, at 2 to 2.5 times the noise", ""]
        each = figures["each alone at twice the noise"].items()
        lines += _table(("effect", *next(iter(each))[1]), [(n, *map(_short, d.values())) for n, d in each])
    if figures["left out"]:
        lines += ["## Every effect taken out of the library, its cases diagnosed (2 to 20 times the noise)", ""]
        head = ("effect", *next(iter(figures["left out"].values())))
        lines += _table(head, [(n, *(str(d[h]) for h in head[1:])) for n, d in figures["left out"].items()])
    lines += ["## Outside the library, by kind", ""]
    by_kind = figures["outside the library"]["by kind"].items()
    lines += _table(
        ("kind", "flagged", "... or said to be what looks the same"),
        [(n, *map(_short, d.values())) for n, d in by_kind],
    )
    off = figures["predicted less reached shrinkage, points"]
    if off["median"] is not None:
        low, high = off["5 to 95 %"]
        lines += [
            f"Predicted less reached shrinkage: median {off['median']:.1f} points, 5 to 95 %: {low:.1f} to {high:.1f}.",
            "",
        ]
    if figures["errors"]:
        lines += ["Cases that ended with an error:", "", *(f"- {e}" for e in figures["errors"]), ""]
    (folder / "report.md").write_text("\n".join(lines))
    _plots(figures, folder)
