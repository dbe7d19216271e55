//! What the pages share: text and pictures that need no other file.

use base64::Engine;
use colluvium::plots::Picture;

/// Text that is safe in HTML, between tags and in attributes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A picture as an `img` that carries its PNG.
pub fn embedded_png(picture: &impl Picture, alt: &str) -> Result<String, String> {
    let bytes = picture.to_png()?;
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    Ok(format!("<img alt=\"{}\" src=\"data:image/png;base64,{text}\">", escape(alt)))
}
