#!/usr/bin/env python3
"""Plants faults in a law one at a time and shows that the law tests kill each.

    tests/law/mutants/run_mutants.py --test build/release/law_test [--only NAME] [--list]
    tests/law/mutants/run_mutants.py --law cyclic_joint --test build/release/law_test --test build/release/cyclic_joint_test

Every fault is a change of text in a scratch copy of contact_models. A text that is not found is an error, since a mutant
without a change proves nothing. The law is rebuilt (baseline instruction set) and the tests run with it. All tests compare
with a formula or with the independent reference, none with stored output. The unchanged law runs first; tests that fail
with it do not count. Exit code 0: all killed, 1: a survivor, 3: a text was not found or a mutant did not build.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

from cyclic_joint_mutants import MUTANTS as CYCLIC_JOINT

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
EQUATIONS = "fracture_energy/equations.h"
SOFTENING = "shim/softening.h"

# name -> (what is wrong, [(file, text, replacement)]). Spaces and line breaks in the text match any white space.
MUTANTS = {
    "v_left_out_of_e": (
        "effective opening e = d_n + w, without the dilation uplift v",
        [
            (EQUATIONS, "step.e = hn::Add(hn::Sub(in.d_n, old.v), old.w);", "step.e = hn::Add(in.d_n, old.w);"),
            (EQUATIONS, "const V e = hn::Add(hn::Sub(in.d_n, old.v), old.w);", "const V e = hn::Add(in.d_n, old.w);"),
            (EQUATIONS, "hn::Sub(in.d_n, old.v), old.w, step.tolerance)", "in.d_n, old.w, step.tolerance)"),
            (EQUATIONS, "hn::Sub(step.d_n, a.v), step.w_old, step.tolerance)", "step.d_n, step.w_old, step.tolerance)"),
        ],
    ),
    "one_step_lag_in_xi": (
        "strength at the xi of the start of the step",
        [
            (EQUATIONS, "const V factor = f.factor(a.xi_s);", "const V factor = f.factor(step.xi_s);"),
            (EQUATIONS, "a.factor = f.factor(xi_s);", "a.factor = f.factor(step.xi_s);"),
        ],
    ),
    "xi_s_for_shared_xi": (
        "shear keeps an xi_s of its own where the shared xi belongs",
        [
            (EQUATIONS, "step.xi_s = kShared ? step.xi_t : old.xi_s;", "step.xi_s = old.xi_s;"),
            (EQUATIONS, "r.state.xi_t = kShared ? a.xi_s : step.xi_t;", "r.state.xi_t = step.xi_t;"),
            ("fracture_energy/kernel.cpp", "xi_s = kShared ? xi_t : in(kStateOld + kXiS);", "xi_s = in(kStateOld + kXiS);"),
        ],
    ),
    "c0_for_c0_less_cr_in_su": (
        "su = G2/(c0 A) instead of G2/((c0 - cr) A)",
        [(EQUATIONS, "su = hn::IfThenElseZero(drops_s, hn::Div(G2, hn::Mul(c_drop, A)));",
          "su = hn::IfThenElseZero(drops_s, hn::Div(G2, hn::Mul(c0, A)));")],
    ),
    "return_to_S_at_old_xi": (
        "tau returns to the strength before this step's slip",
        [(EQUATIONS, "a = after_slip<kTangent>(step, a, hn::MulAdd(r.slip, p.inv_su, xi_start));",
          "r.slip = select(r.slips, hn::Div(hn::Sub(trial, S_before_slip), p.ks), r.slip);"
          " a = after_slip<kTangent>(step, a, hn::MulAdd(r.slip, p.inv_su, xi_start)); a.S = select(r.slips, S_before_slip, a.S);")],
    ),
    "missing_branch_end": (
        "linear softening runs on below zero",
        [(SOFTENING, "HWY_INLINE V factor(V xi) const { return positive_part(hn::Sub(splat(1.0), xi)); }",
          "HWY_INLINE V factor(V xi) const { return hn::Sub(splat(1.0), xi); }")],
    ),
    "half_kn_on_reclosing": (
        "a joint damaged in tension closes with kn/2",
        [
            (EQUATIONS, "const V sigma = hn::Mul(p.kn, e);",
             "const V sigma = hn::Mul(hn::Mul(p.kn, e), hn::IfThenElse(hn::Gt(old.xi_t, zero()), splat(0.5), splat(1.0)));"),
            (EQUATIONS, "r.sigma = a.sigma;",
             "r.sigma = hn::IfThenElse(hn::AndNot(step.open, hn::Gt(old.xi_t, zero())), hn::Mul(splat(0.5), a.sigma), a.sigma);"),
        ],
    ),
    "wrong_sign_of_coulomb_in_tension": (
        "tension raises the shear strength",
        [
            (EQUATIONS, "a.S_end = hn::NegMulAdd(a.sigma, p.mur, step.c_end);",
             "a.S_end = hn::MulAdd(hn::Abs(a.sigma), p.mur, step.c_end);"),
            (EQUATIONS, "a.S_drop = hn::NegMulAdd(a.sigma, p.mu_drop, step.c_drop);",
             "a.S_drop = hn::MulAdd(hn::Abs(a.sigma), p.mu_drop, step.c_drop);"),
        ],
    ),
    "F_at_the_old_w": (
        "crushing strength at the plastic closure of the start of the step",
        [
            (EQUATIONS, "const V fall = hn::Add(p.kn, crushing_slope(w_old));", "const V fall = p.kn;"),
            (EQUATIONS, "w = select(hn::Lt(highest, p.wu), hn::Min(straight, highest), highest);", "w = straight;"),
            (EQUATIONS, "value = overstress(d_n_less_v, x);",
             "value = hn::Sub(hn::Neg(hn::Mul(p.kn, hn::Add(d_n_less_v, x))), crushing_strength(w_old));"),
            (EQUATIONS, "slope = hn::Neg(hn::Add(p.kn, crushing_slope(x)));", "slope = hn::Neg(p.kn);"),
            (EQUATIONS, "lowest = hn::Sub(zero(), crushing_strength(c.w));", "lowest = hn::Sub(zero(), crushing_strength(w_old));"),
        ],
    ),
    "slip_direction_lost_on_reversal": (
        "tau keeps its sign when the slip reverses",
        [(EQUATIONS, "r.state.tau_s = select(r.slips, hn::Mul(hn::Mul(trial_s, inv_trial), a.S), trial_s);",
          "r.state.tau_s = select(r.slips, hn::CopySign(hn::Mul(hn::Mul(trial_s, inv_trial), a.S), old.tau_s), trial_s);")],
    ),
    "residual_cohesion_kept_when_open": (
        "cohesion cr + (c0 - cr) f while the joint is open",
        [
            (EQUATIONS, "step.c_end = hn::IfThenZeroElse(step.open, p.cr);", ""),
            (EQUATIONS, "step.c_drop = select(step.open, p.c0, p.c_drop);", ""),
        ],
    ),
    "angle_interpolated_before_tangent": (
        "tan(phi0 + (phir - phi0) D) instead of mu0 + (mur - mu0) D",
        [(EQUATIONS, "coulomb(const AtSlip& a, V factor) const { return hn::MulAdd(a.S_drop, factor, a.S_end); }",
          "coulomb(const AtSlip& a, V factor) const { HWY_ALIGN double m0[64], mr[64], ff[64]; const D d;"
          " hn::Store(p.mu0, d, m0); hn::Store(p.mur, d, mr); hn::Store(factor, d, ff);"
          " for (std::size_t i = 0; i < hn::Lanes(d); ++i)"
          " m0[i] = std::tan(std::atan(mr[i]) + (std::atan(m0[i]) - std::atan(mr[i])) * ff[i]);"
          " const V excess = hn::Sub(hn::Load(d, m0), hn::MulAdd(p.mu_drop, factor, p.mur));"
          " return hn::NegMulAdd(a.sigma, excess, hn::MulAdd(a.S_drop, factor, a.S_end)); }")],
    ),
}
LAWS = {"fracture_energy": MUTANTS, "cyclic_joint": CYCLIC_JOINT}
NOT_FOUND = 3


def plant(folder, changes):
    """Applies the changes; returns the texts that were not found."""
    missing = []
    for name, text, replacement in changes:
        path = folder / name
        source = path.read_text()
        pattern = r"\s*".join(re.escape(word) for word in re.findall(r"\w+|[^\w\s]", text))
        changed, count = re.subn(pattern, lambda _: replacement, source)
        if count == 0:
            missing.append(f"{name}: {text}")
        path.write_text(changed)
    return missing


def run_tests(programs, law, laws, timeout, known=()):
    """Returns (names of failed tests, first failed path check of a test that is not among the known failures)."""
    environment = dict(os.environ, QUOIN_LAW_PATH=str(laws), QUOIN_TEST_SCALE=os.environ.get("QUOIN_TEST_SCALE", "0.4"))
    failed, first, crashed = [], "", ""
    files = "Files/*" if law == "fracture_energy" else f"Files/*{law}*"
    groups = [(program, chosen) for program in programs
              for chosen in ((files, "*Statement*", "Reference*") if program.name == "law_test" and law == "fracture_energy"
                             else (files,) if program.name == "law_test" else ("*",))]
    for program, chosen in groups:
        try:
            done = subprocess.run([program, f"--gtest_filter={chosen}", "--gtest_brief=1"], env=environment, timeout=timeout,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", check=False)
        except subprocess.TimeoutExpired:
            failed.append(f"{chosen} did not end within {timeout} s")
            continue
        failed += sorted(set(re.findall(r"^\[  FAILED  \] ([\w/.]+),? ", done.stdout, re.M)))
        if done.returncode < 0:
            crashed = f"{chosen} ended by signal {-done.returncode}"
            failed.append(crashed)
        if not first:
            for line, stem in re.findall(r"^\S*/(([\w-]+)\.toml:\d+: .*)$", done.stdout, re.M):
                if not any(test.endswith("/" + stem) for test in known):
                    first = line
                    break
    return failed, first


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--law", choices=sorted(LAWS), default="fracture_energy")
    parser.add_argument("--test", type=pathlib.Path, action="append", default=[], help="a test program (may be repeated)")
    parser.add_argument("--only", action="append", help="this mutant (may be repeated)")
    parser.add_argument("--list", action="store_true", help="list the mutants and check that their texts are found")
    parser.add_argument("--timeout", type=int, default=300, help="seconds for one group of tests")
    arguments = parser.parse_args()
    mutants = LAWS[arguments.law]
    chosen = arguments.only or list(mutants)
    for name in set(chosen) - set(mutants):
        parser.error(f"--only {name}: {arguments.law} has no such mutant; --list names them")

    with tempfile.TemporaryDirectory(prefix="quoin-mutants-") as scratch_name:
        scratch = pathlib.Path(scratch_name)
        lost = {}
        for name in chosen:  # all texts are checked before the builds, which take minutes
            shutil.copytree(ROOT / "contact_models", scratch / name / "models")
            missing = plant(scratch / name / "models", mutants[name][1])
            if missing:
                lost[name] = missing
        for name, missing in lost.items():
            print(f"{name}: text not found; mend this mutant for the new source:", *missing, sep="\n    ", file=sys.stderr)
        if lost:
            return NOT_FOUND
        if arguments.list:
            for name in chosen:
                print(f"{name:36} {mutants[name][0]}")
            return 0
        if not arguments.test or not all(program.is_file() for program in arguments.test):
            parser.error("--test PROGRAM is needed: build the target law_test")
        programs = [program.resolve() for program in arguments.test]

        def build(models, laws):
            laws.mkdir()
            done = subprocess.run([HERE / "build_law.sh", models, arguments.law, laws / f"{arguments.law}.so"], stderr=subprocess.PIPE, text=True,
                                  check=False)
            if done.returncode != 0:
                print(done.stderr[-3000:], file=sys.stderr)
            return done.returncode == 0

        if not build(ROOT / "contact_models", scratch / "unchanged"):
            return NOT_FOUND
        baseline, _ = run_tests(programs, arguments.law, scratch / "unchanged", arguments.timeout)
        print(f"unchanged law: {len(baseline)} tests fail{': ' + ', '.join(baseline) if baseline else ''}", flush=True)

        survivors, broken = [], []
        for name in chosen:
            start = time.time()
            if not build(scratch / name / "models", scratch / name / "laws"):
                broken.append(name)
                print(f"BROKEN    {name}: does not build", flush=True)
                continue
            failed, first = run_tests(programs, arguments.law, scratch / name / "laws", arguments.timeout, baseline)
            new = [test for test in failed if test not in baseline]
            groups = {"path files": [t for t in new if t.startswith("Files/")], "statements": [t for t in new if "Statement" in t],
                      "reference": [t for t in new if re.match("Reference|Page|Neutral", t)]}
            print(f"{'killed' if new else 'SURVIVED':9} {name}: {mutants[name][0]} ({time.time() - start:.0f} s)")
            print("          " + ", ".join(f"{len(tests)} {group}" for group, tests in groups.items()) +
                  (f"; {', '.join(t for t in new if t not in sum(groups.values(), []))}" if len(new) > sum(map(len, groups.values())) else ""))
            if first and groups["path files"]:
                print(f"          {first[:220]}")
            sys.stdout.flush()
            if not new:
                survivors.append(name)
        print(f"{len(chosen) - len(survivors) - len(broken)} of {len(chosen)} mutants killed")
        return NOT_FOUND if broken else 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
