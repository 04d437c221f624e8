"""Tables as LaTeX takes them."""

from jaxwalk.report.latex import escaped, latex_table
from jaxwalk.report.table import NONE, Table


def test_a_table():
    table = Table(("driver", "goal %", "p"), (("rule_based", "1.0 [0.5, 2.0]", "< 0.001"), ("random", NONE, "0.5")))
    assert latex_table(table, "Goals & p", "pairs").splitlines()[1:] == [
        r"\begin{table*}",
        r"\centering",
        r"\caption{Goals \& p}",
        r"\label{tab:pairs}",
        r"\begin{tabular}{lrr}",
        r"\toprule",
        r"driver & goal \% & p \\",
        r"\midrule",
        r"rule\_based & 1.0 [0.5, 2.0] & \textless{} 0.001 \\",
        r"random & -- & 0.5 \\",
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table*}",
    ]


def test_every_sign_is_escaped_once():
    assert escaped(r"\{a}_$#") == r"\textbackslash{}\{a\}\_\$\#"
    assert escaped("1 m/s², 2 × 3") == r"1 m/s\textsuperscript{2}, 2 \texttimes{} 3"
