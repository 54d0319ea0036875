//! Typed buffers.

use bytemuck::Pod;
use std::marker::PhantomData;

/// A buffer that holds `T`s.
#[derive(Debug)]
pub struct GpuBuffer<T> {
    raw: wgpu::Buffer,
    length: usize,
    of: PhantomData<T>,
}

impl<T: Pod> GpuBuffer<T> {
    /// A read-only storage buffer with `data`. WebGPU binds no empty buffer, so an empty one holds
    /// one zero element.
    pub fn storage(device: &wgpu::Device, label: &str, data: &[T]) -> Self {
        let zero = [T::zeroed()];
        let data = if data.is_empty() { &zero[..] } else { data };
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let raw = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.len().next_multiple_of(16) as u64,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: true,
        });
        raw.get_mapped_range_mut(..bytes.len() as u64)
            .expect("the buffer was created mapped")
            .slice(..)
            .copy_from_slice(bytes);
        raw.unmap();
        Self {
            raw,
            length: data.len(),
            of: PhantomData,
        }
    }

    /// A buffer of `length` zeros.
    pub fn zeroed(
        device: &wgpu::Device,
        label: &str,
        length: usize,
        usage: wgpu::BufferUsages,
    ) -> Self {
        let raw = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (length.max(1) * size_of::<T>()) as u64,
            usage,
            mapped_at_creation: false,
        });
        Self {
            raw,
            length,
            of: PhantomData,
        }
    }

    /// The wgpu buffer.
    pub fn raw(&self) -> &wgpu::Buffer {
        &self.raw
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Size in bytes.
    pub fn bytes(&self) -> u64 {
        (self.length * size_of::<T>()) as u64
    }

    /// Records that the elements of `range` become zero; their bytes are a multiple of four.
    pub fn clear(&self, encoder: &mut wgpu::CommandEncoder, range: std::ops::Range<usize>) {
        let size = size_of::<T>() as u64;
        let bytes = range.len() as u64 * size;
        encoder.clear_buffer(&self.raw, range.start as u64 * size, Some(bytes));
    }

    /// The whole buffer as a binding.
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        self.raw.as_entire_binding()
    }
}
