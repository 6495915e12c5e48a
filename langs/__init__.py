"""Text to tree: the Lark grammars, the syntax tree with spans, the parser with recovery and the formatter."""
