"""Several pictures in one file: a strip of frames, or an animation."""

import math
import pathlib
import shutil
import subprocess

from rendering.faults import fail

LARGEST_STRIP = 300_000  # bytes
FILM_WIDTH = 720  # pixels of a GIF or WebP at most: their files are large


def pillow():
    try:
        from PIL import Image
    except ImportError:
        fail("strips and GIFs need Pillow (Debian: apt-get install python3-pil)")
    return Image


def check_strip(path):
    """Before anything is drawn."""
    if path.suffix.lower() != ".png":
        fail(f"--strip is '{path}' and must end in .png")
    pillow()


def write_strip(pictures, path):
    """Pictures side by side, four or more in two rows, in a palette and if need be reduced until the file is small."""
    Image = pillow()
    path.parent.mkdir(parents=True, exist_ok=True)
    images = [Image.open(picture).convert("RGB") for picture in pictures]
    rows = 1 if len(images) < 4 else 2
    columns = math.ceil(len(images) / rows)
    width, height = images[0].size
    whole = Image.new("RGB", (columns * width, rows * height), images[0].getpixel((0, 0)))
    for n, image in enumerate(images):
        whole.paste(image, (n % columns * width, n // columns * height))
    scale = min(1.0, 1600 / whole.width)
    while True:
        size = (max(16, round(whole.width * scale)), max(16, round(whole.height * scale)))
        small = whole.resize(size, Image.LANCZOS)
        for colors in (256, 128, 64):
            # Pillow only dithers towards a palette that is given.
            palette = small.quantize(colors, method=Image.Quantize.MAXCOVERAGE, kmeans=2)
            keep_color(palette, small.getpixel((0, 0)))
            small.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
            if path.stat().st_size < LARGEST_STRIP or scale < 0.05:
                return
        scale *= 0.88


def keep_color(palette, color):
    """Makes the nearest entry exact: a background that should be white would otherwise be nearly so."""
    entries = palette.getpalette()
    distances = [sum((entries[i + c] - color[c]) ** 2 for c in range(3)) for i in range(0, len(entries) - 2, 3)]
    at = 3 * distances.index(min(distances))
    palette.putpalette(entries[:at] + list(color) + entries[at + 3:])


def check_animation(path):
    """Before anything is drawn."""
    kind = path.suffix.lower()
    if kind not in (".mp4", ".gif", ".webp"):
        fail(f"--animation is '{path}' and must end in .mp4, .gif or .webp")
    if kind == ".mp4":
        if not shutil.which("ffmpeg"):
            fail("an MP4 needs ffmpeg (Debian: apt-get install ffmpeg); a GIF does not")
        return
    pillow()


def write_animation(pictures, path, rate, scratch, largest):
    """`scratch`: an empty or temporary folder; `largest`: bytes of a GIF or WebP, which is reduced until it has no more."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() == ".mp4":
        write_mp4(pictures, path, rate, scratch)
        return
    Image = pillow()
    originals = [Image.open(picture).convert("RGB") for picture in pictures]
    width, height = originals[0].size
    scale = min(1.0, FILM_WIDTH / width)
    write = write_gif if path.suffix.lower() == ".gif" else write_webp
    while True:
        size = (max(16, round(width * scale)), max(16, round(height * scale)))
        write(Image, [image.resize(size, Image.LANCZOS) for image in originals], path, rate)
        ratio = path.stat().st_size / largest
        if ratio <= 1.0 or min(size) == 16:
            return
        scale *= max(0.5, 0.97 / ratio ** 0.5)  # bytes grow a little slower than pixels


def write_mp4(pictures, path, rate, scratch):
    # ffmpeg counts from one name to the next, so pictures get names of their own.
    links = [scratch / f"animation_{n:06}.png" for n in range(len(pictures))]
    for link, picture in zip(links, pictures):
        link.symlink_to(pathlib.Path(picture).resolve())
    # Players need 4:2:0, which needs even sides.
    command = ["ffmpeg", "-y", "-loglevel", "error", "-framerate", f"{rate:g}", "-i", str(scratch / "animation_%06d.png"),
               "-vf", "scale=trunc(iw/2)*2:trunc(ih/2)*2", "-c:v", "libx264", "-preset", "slow", "-crf", "18",
               "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path)]
    status = subprocess.run(command, stdin=subprocess.DEVNULL)
    if status.returncode != 0:
        fail(f"ffmpeg did not write '{path}': its message is above")


def write_gif(Image, images, path, rate):
    # One palette for all, from a sheet of some of them: with palettes that change, still parts flicker.
    some = [image.reduce(2) for image in images[::max(1, len(images) // 10)]]
    sheet = Image.new("RGB", (some[0].width, some[0].height * len(some)))
    for n, image in enumerate(some):
        sheet.paste(image, (0, n * image.height))
    palette = sheet.quantize(256, method=Image.Quantize.MAXCOVERAGE, kmeans=2)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=duration(rate), loop=0, optimize=True)


def write_webp(Image, images, path, rate):
    images[0].save(path, save_all=True, append_images=images[1:], duration=duration(rate), loop=0, quality=75, method=4)


def duration(rate):
    """Of a picture, ms; viewers show shorter ones slowly."""
    return max(20, round(1000 / rate))
