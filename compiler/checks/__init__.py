"""Names, types and meanings of declarations: syntax in, IR or diagnostics out."""
