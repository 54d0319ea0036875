//! The size of a kernel.

use direkt::error::GpuError;
use naga::back::spv;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use serde::Serialize;

/// How large a kernel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ShaderSize {
    /// Bytes of WGSL.
    pub wgsl_bytes: usize,
    /// Functions, the entry point among them.
    pub functions: usize,
    /// Instructions of SPIR-V, declarations included, without the checks that wgpu adds and before
    /// any optimisation: what a driver begins with.
    pub spirv_instructions: usize,
}

impl ShaderSize {
    /// The size of `wgsl`.
    ///
    /// # Errors
    /// It is not valid.
    pub fn of(wgsl: &str) -> Result<Self, GpuError> {
        let fail = |message: String| GpuError::Shader {
            entry: "kernel::direct".to_owned(),
            message,
        };
        let module = naga::front::wgsl::parse_str(wgsl).map_err(|e| fail(e.to_string()))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .map_err(|e| fail(e.to_string()))?;
        let words = spv::write_vec(&module, &info, &spv::Options::default(), None)
            .map_err(|e| fail(e.to_string()))?;
        Ok(Self {
            wgsl_bytes: wgsl.len(),
            functions: module.functions.len() + module.entry_points.len(),
            spirv_instructions: instructions(&words),
        })
    }
}

/// Instructions of a SPIR-V module: after a header of 5 words each begins with its length in the
/// upper half of a word (SPIR-V 1.6, §2.3).
fn instructions(words: &[u32]) -> usize {
    let mut count = 0;
    let mut at = 5;
    while let Some(first) = words.get(at) {
        count += 1;
        at += ((first >> 16) as usize).max(1);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instructions_are_counted_by_their_lengths() {
        let words = [0x0723_0203, 0, 0, 0, 0, 3 << 16, 7, 7, 1 << 16, 2 << 16, 9];
        assert_eq!(instructions(&words), 3);
        assert_eq!(instructions(&words[..5]), 0);
    }

    #[test]
    fn more_code_is_larger() {
        let kernel = |body: &str| {
            format!(
                "@group(0) @binding(0) var<storage, read_write> x: array<f32>;\n\
                 @compute @workgroup_size(1) fn main() {{ {body} }}"
            )
        };
        let size = |body: &str| ShaderSize::of(&kernel(body)).expect("it is valid");
        let (small, large) = (size("x[0] = 1.0;"), size("x[0] = sqrt(x[1]) + sin(x[2]);"));
        assert_eq!((small.functions, large.functions), (1, 1));
        assert!(small.spirv_instructions < large.spirv_instructions);
        assert!(ShaderSize::of("fn f( {").is_err());
    }
}
