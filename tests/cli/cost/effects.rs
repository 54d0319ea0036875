//! `direkt cost --effects`: the same image in another time.

use super::super::{run, text};
use super::{CORNELL, read};
use serde_json::Value;

/// Errors at equal samples are equal, images the same in all bits, and the ratio of efficiencies is
/// the inverse of that of times. What the scene calls for anyway is said to be.
#[test]
fn effects_without_need_cost_time_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [json, csv] = ["a.json", "a.csv"].map(|n| folder.path().join(n));
    let arguments = [
        "cost",
        CORNELL,
        "--size",
        "24x16",
        "--budget",
        "2s",
        "--strategies",
        "light-area",
        "--samplers",
        "sobol",
        "--effects",
        "depth-of-field,rectangles,glossy",
        "-o",
        text(folder.path()),
        "--json",
        text(&json),
        "--csv",
        text(&csv),
    ];
    let (code, stdout, stderr) = run(&arguments);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(
        stdout.contains("light-area · sobol · + glossy: "),
        "{stdout}"
    );
    assert!(stdout.contains("the same image bit for bit ("), "{stdout}");

    let facts: Value = serde_json::from_str(&read(&json)).unwrap();
    let scene = &facts["scenes"][0];
    let estimators = scene["estimators"].as_array().unwrap();
    let of = |key: &str| {
        estimators
            .iter()
            .map(|e| e[key].as_str().unwrap())
            .collect::<Vec<_>>()
    };
    assert_eq!(of("effects"), ["called-for", "depth-of-field", "glossy"]);
    let names = ["called for", "+ depth-of-field", "+ glossy"];
    assert_eq!(
        of("name"),
        names.map(|n| format!("light-area · sobol · {n}"))
    );
    assert_eq!(estimators[0]["without_need"], Value::Null);
    for e in &estimators[1..] {
        check_without_need(e, &estimators[0]);
    }
    let not = scene["not_applicable"].as_array().unwrap();
    assert_eq!(not.len(), 1);
    assert_eq!(not[0]["effects"], "rectangles");
    let reason = not[0]["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("the scene calls for it anyway: "),
        "{reason}"
    );
    assert!(stdout.contains(reason), "{stdout}");

    check_table(
        &read(&csv),
        estimators[0]["points"].as_array().unwrap().len(),
    );
    let page = read(&folder.path().join("report.html"));
    let heading = "Effects that the scene does not call for";
    for expected in [
        heading,
        names[0],
        names[1],
        names[2],
        "All images were the same",
        reason,
    ] {
        assert!(page.contains(expected), "{expected}");
    }
    assert_eq!(page.matches("<svg ").count(), 4);
    assert!(folder.path().join("cornell-effects.svg").is_file());
    assert!(folder.path().join("cornell-effects.png").is_file());
}

fn check_without_need(e: &Value, called_for: &Value) {
    let need = &e["without_need"];
    assert_eq!(need["against"], 0);
    assert_eq!(need["effects"], serde_json::json!([e["effects"]]));
    assert_eq!(need["pixels_differ"], 0);
    let images = need["images"].as_u64().unwrap();
    assert_eq!(need["pixels"], 24 * 16 * images);
    let points = |e: &Value| e["points"].as_array().unwrap().clone();
    let pairs: Vec<_> = points(e).into_iter().zip(points(called_for)).collect();
    assert_eq!(pairs.len(), points(called_for).len());
    let replicates = pairs.iter().map(|(p, _)| p["replicates"].as_u64().unwrap());
    assert_eq!(images, replicates.sum::<u64>());
    for (with, without) in &pairs {
        for key in ["samples", "replicates", "mse", "rel_mse"] {
            assert_eq!(with[key], without[key], "{key}");
        }
    }

    let number = |value: &Value| value.as_f64().unwrap();
    let [times, efficiencies] = ["time_ratio", "efficiency_ratio"].map(|k| &need[k]);
    let inverse = number(&times["value"]) * number(&efficiencies["value"]);
    assert!((inverse - 1.0).abs() < 1e-9, "{need}");
    let ends = number(&times["low"]) * number(&efficiencies["high"]);
    assert!((ends - 1.0).abs() < 1e-9, "{need}");
    let efficiency = |e: &Value| number(&e["efficiency"]["value"]);
    let ratio = efficiency(e) / efficiency(called_for);
    assert!(
        (ratio / number(&efficiencies["value"]) - 1.0).abs() < 1e-9,
        "{need}"
    );
    let compile = number(&e["compile_seconds"]) / number(&called_for["compile_seconds"]);
    assert!((compile - number(&need["compile_ratio"])).abs() < 1e-9);
    // A tie is what the ratio says.
    let low = number(&times["low"]);
    let tie = low <= 1.0 && number(&times["high"]) >= 1.0;
    let ties = e["ties"].as_array().unwrap();
    assert_eq!(ties.contains(&0.into()), tie, "{e}");
}

/// Every count of samples has a line for each set of effects, with the same error.
fn check_table(csv: &str, counts: usize) {
    let mut lines = csv.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    let column = |line: &str, name: &str| {
        let at = header.iter().position(|column| *column == name).unwrap();
        line.split(',').nth(at).unwrap().to_owned()
    };
    let lines: Vec<_> = lines.collect();
    let of = |effects: &str| -> Vec<[String; 2]> {
        let mine = lines.iter().filter(|l| column(l, "effects") == effects);
        mine.map(|l| [column(l, "spp"), column(l, "relmse")])
            .collect()
    };
    let called_for = of("called-for");
    assert_eq!(called_for.len(), counts);
    assert_eq!(lines.len(), 3 * counts);
    assert_eq!(of("depth-of-field"), called_for);
    assert_eq!(of("glossy"), called_for);
}

#[test]
fn effects_are_named_as_explain_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |effects: &str| {
        let flags = [
            "cost",
            CORNELL,
            "--effects",
            effects,
            "-o",
            text(folder.path()),
        ];
        let (code, stdout, stderr) = run(&flags);
        assert_eq!((code, stdout.as_str()), (2, ""), "{effects}: {stderr}");
        stderr
    };
    // A name that is none, and a way of sampling.
    for effects in ["depth-of-field,blur", "sobol-sampler"] {
        let message = refused(effects);
        let expected =
            "no effect of this name can be compiled in without need; expected geometry, triangles";
        assert!(message.contains(expected), "{message}");
        assert!(message.contains("light-groups, or everything"), "{message}");
    }
    let flags = ["cost", CORNELL, "--calibrate", "--effects", "everything"];
    let (code, _, stderr) = run(&flags);
    assert_eq!(code, 2);
    assert!(stderr.contains("cannot be used with"), "{stderr}");
}
