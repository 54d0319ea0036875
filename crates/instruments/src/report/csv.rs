//! A table of all measured points.

use crate::cost::{Estimator, EstimatorCost, Point, SceneCost};
use std::path::Path;

/// The columns: first those that tables of other renderers have, then further ones. `effects` are
/// those that the estimator is compiled with: `called-for`, or what else is compiled in, the name
/// of an effect or `everything`.
pub const HEADER: &str = "scene,sampler,strategy,spp,seconds,relmse,efficiency,light_sampling,light_selection,shadow_rays,shadow_pattern,width,height,replicates,\
                          seconds_low,seconds_high,relmse_low,relmse_high,efficiency_low,efficiency_high,mse,mse_low,mse_high,effects";

/// One line per scene, estimator and number of samples.
pub fn table(costs: &[SceneCost]) -> String {
    let mut out = format!("{HEADER}\n");
    for cost in costs {
        for estimator in &cost.estimators {
            for point in &estimator.points {
                out.push_str(&line(cost, estimator, point));
                out.push('\n');
            }
        }
    }
    out
}

fn line(cost: &SceneCost, estimator: &EstimatorCost, p: &Point) -> String {
    let name = Path::new(&cost.scene).file_name();
    let name = name.map_or_else(|| cost.scene.clone().into(), |n| n.to_string_lossy());
    let Estimator {
        settings: e,
        effects,
    } = estimator.estimator;
    let numbers = [
        p.seconds.low,
        p.seconds.high,
        p.rel_mse.low,
        p.rel_mse.high,
        p.efficiency.low,
        p.efficiency.high,
        p.mse.value,
        p.mse.low,
        p.mse.high,
    ];
    let numbers: Vec<_> = numbers.iter().map(|x| format!("{x:e}")).collect();
    format!(
        "{},{},{},{},{:.6},{:e},{:e},{},{},{},{},{},{},{},{},{}",
        quoted(&name),
        e.sampler,
        e.strategy,
        p.samples,
        p.seconds.value,
        p.rel_mse.value,
        p.efficiency.value,
        if e.strategy.is_mis() {
            e.light_sampling.to_string()
        } else {
            String::new()
        },
        e.light_selection,
        e.shadow_rays,
        e.shadow_pattern,
        cost.width,
        cost.height,
        p.replicates,
        numbers.join(","),
        effects.key()
    )
}

/// A field; in quotes where it needs them (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_are_quoted() {
        assert_eq!(quoted("a.toml"), "a.toml");
        assert_eq!(quoted("a,\"b\".toml"), "\"a,\"\"b\"\".toml\"");
    }
}
