//! How many shadow rays a render has.

use super::Session;
use super::progress::Progress;
use crate::error::GpuError;
use crate::gpu::layout::PixelState;
use crate::prepare::Patterns;
use crate::render::scouts::{SAMPLES, is_scout, pay};
use crate::scene::{ShadowGrid, ShadowRays};

/// The class of scouts.
const SCOUTS: usize = 1;

impl Session<'_> {
    /// Shadow rays per camera ray, with light selection `all` per light.
    pub fn shadow_rays(&self) -> u32 {
        self.frame_data.shadow.rays
    }

    pub(super) fn set_shadow_rays(&mut self, rays: u32) -> Result<(), GpuError> {
        self.film.shadow_rays = rays;
        self.frame_data.shadow = ShadowGrid::new(rays).into();
        self.frame_data.patterns = Patterns::new(self.film.sampler, self.planned, rays).into();
        self.write_frame()
    }

    /// Asks a few pixels, where the settings leave it open and nobody has been asked. Their samples
    /// are no part of the image.
    pub(super) fn choose_shadow_rays(&mut self) -> Result<(), GpuError> {
        if self.progress.shadow_rays.is_some() {
            return Ok(());
        }
        let rays = match self.asked_rays {
            ShadowRays::Number(rays) => rays,
            ShadowRays::Auto => {
                let before = std::mem::replace(&mut self.progress, Progress::of_scouts());
                let found = self.ask_scouts();
                self.progress = before;
                self.sort_pixels()?;
                let [one, several] = found?;
                if pay(&one, &several, (self.film.sampler, self.adaptive)) {
                    ShadowRays::SEVERAL
                } else {
                    1
                }
            }
        };
        self.set_shadow_rays(rays)?;
        self.progress.shadow_rays = Some(rays);
        self.saved.progress.shadow_rays = Some(rays);
        Ok(())
    }

    /// What scouts have with one shadow ray and with several.
    fn ask_scouts(&mut self) -> Result<[Vec<PixelState>; 2], GpuError> {
        let size = self.film.size;
        for region in &mut self.regions {
            region.sort(self.context, size, 2, |pixel| {
                usize::from(is_scout(pixel, size))
            });
        }
        let mut found = [Vec::new(), Vec::new()];
        for (rays, found) in [1, ShadowRays::SEVERAL].into_iter().zip(&mut found) {
            self.set_shadow_rays(rays)?;
            for region in 0..self.regions.len() {
                self.bring(region, &[0, SAMPLES], &mut || false)?;
                let region = &self.regions[region];
                let rows = region.rows[SCOUTS].clone();
                found.extend(self.read_rows(region, rows.clone())?.states);
                self.clear(std::iter::once((region, rows)))?;
            }
        }
        Ok(found)
    }
}
