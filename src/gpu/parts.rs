//! Arrays in several buffers, each as long as a binding may be.

use super::buffer::GpuBuffer;
use bytemuck::Pod;

/// An array in parts; those that it does not fill are bound to the first one.
#[derive(Debug)]
pub struct Parts<T>(Vec<GpuBuffer<T>>);

impl<T: Pod> Parts<T> {
    /// Storage buffers of `items` items of `data` each; a single one where it is not split.
    pub fn storage(device: &wgpu::Device, label: &str, data: &[T], items: Option<usize>) -> Self {
        let buffer = |part: &[T]| GpuBuffer::storage(device, label, part);
        match items {
            Some(items) if !data.is_empty() => Self(data.chunks(items).map(buffer).collect()),
            _ => Self(vec![buffer(data)]),
        }
    }

    /// Size of all parts in bytes.
    pub fn bytes(&self) -> u64 {
        self.0.iter().map(GpuBuffer::bytes).sum()
    }

    /// Part `index` as a binding.
    pub fn binding(&self, index: usize) -> wgpu::BindingResource<'_> {
        self.0.get(index).unwrap_or(&self.0[0]).binding()
    }
}

/// Bytes of the longest part of `data`.
pub(crate) fn largest_part<T>(data: &[T], items: Option<usize>) -> u64 {
    let items = items.map_or(data.len(), |items| items.min(data.len()));
    (items * size_of::<T>()) as u64
}
