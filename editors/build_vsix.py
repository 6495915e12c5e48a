"""Packs the VS Code extension, offline: python editors/build_vsix.py [FOLDER]; then `code --install-extension FILE`."""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

FOLDER = Path(__file__).resolve().parent / "vscode"
TYPES = """<?xml version="1.0" encoding="utf-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="json" ContentType="application/json"/><Default Extension="js" ContentType="application/javascript"/>
<Default Extension="vsixmanifest" ContentType="text/xml"/></Types>
"""
MANIFEST = """<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
<Metadata><Identity Language="en-US" Id={name} Version={version} Publisher={publisher}/>
<DisplayName>{title}</DisplayName><Description xml:space="preserve">{description}</Description>
<Categories>Programming Languages</Categories><Properties>
<Property Id="Microsoft.VisualStudio.Code.Engine" Value={engine}/></Properties></Metadata>
<Installation><InstallationTarget Id="Microsoft.VisualStudio.Code"/></Installation><Dependencies/>
<Assets><Asset Type="Microsoft.VisualStudio.Code.Manifest" Path="extension/package.json" Addressable="true"/></Assets>
</PackageManifest>
"""


def build(folder: Path) -> Path:
    """The packed extension in `folder`; the same bytes for the same files."""
    package = json.loads((FOLDER / "package.json").read_text(encoding="utf-8"))
    values = {key: quoteattr(package[key]) for key in ("name", "version", "publisher")}
    manifest = MANIFEST.format(
        **values, title=package["displayName"], description=package["description"],
        engine=quoteattr(package["engines"]["vscode"]),
    )  # fmt: skip
    target = folder / f"{package['name']}-{package['version']}.vsix"
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        texts = {"[Content_Types].xml": TYPES, "extension.vsixmanifest": manifest}
        for path in sorted(FOLDER.rglob("*")):
            if path.suffix in (".json", ".js"):
                texts[f"extension/{path.relative_to(FOLDER).as_posix()}"] = path.read_text(encoding="utf-8")
        for name, text in texts.items():
            archive.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED)
    return target


if __name__ == "__main__":
    print(build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd()))
