//! What the pages share: text and pictures that need no other file.

use base64::Engine;
use colluvium::case::plot::Picture;

/// Text that is safe in HTML, between tags and in attributes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A picture as an `img` that carries its PNG.
pub fn embedded_png(picture: &impl Picture, alt: &str) -> Result<String, String> {
    let file = std::env::temp_dir().join(format!("colluvium-figure-{}.png", std::process::id()));
    picture.write(&file).map_err(|error| error.to_string())?;
    let bytes = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    // A file left behind in the temporary folder does no harm.
    let _ = std::fs::remove_file(&file);
    let text = base64::engine::general_purpose::STANDARD.encode(bytes);
    Ok(format!("<img alt=\"{}\" src=\"data:image/png;base64,{text}\">", escape(alt)))
}
