// The client: starts `tamplang lsp` and hands its answers to the editor. It needs nothing that is not in this folder.
"use strict";
const vscode = require("vscode");
const { Connection } = require("./rpc");

const SELECTOR = { language: "tamplang" };
let connection;

const range = (r) => new vscode.Range(r.start.line, r.start.character, r.end.line, r.end.character);
const place = (l) => new vscode.Location(vscode.Uri.parse(l.uri), range(l.range));
const edit = (e) => new vscode.TextEdit(range(e.range), e.newText);
const markdown = (c) => new vscode.MarkdownString(typeof c === "string" ? c : c.value);
const at = (document, position) => ({ textDocument: { uri: document.uri.toString() }, position });
const of = (document) => ({ textDocument: { uri: document.uri.toString() } });

function workspaceEdit(found) {
  const made = new vscode.WorkspaceEdit();
  for (const [uri, edits] of Object.entries(found.changes || {})) made.set(vscode.Uri.parse(uri), edits.map(edit));
  return made;
}

function completion(item) {
  const made = new vscode.CompletionItem(item.label, item.kind - 1);
  made.detail = item.detail;
  if (item.documentation) made.documentation = markdown(item.documentation);
  if (item.insertText) made.insertText = new vscode.SnippetString(item.insertText);
  return made;
}

function symbol(s) {
  const made = new vscode.DocumentSymbol(s.name, s.detail || "", s.kind - 1, range(s.range), range(s.selectionRange));
  made.children = (s.children || []).map(symbol);
  return made;
}

function diagnostic(d) {
  const made = new vscode.Diagnostic(range(d.range), d.message, d.severity - 1);
  made.source = d.source;
  made.code = d.codeDescription ? { value: d.code, target: vscode.Uri.parse(d.codeDescription.href) } : d.code;
  made.relatedInformation = (d.relatedInformation || []).map(
    (r) => new vscode.DiagnosticRelatedInformation(place(r.location), r.message)
  );
  if (d.tags) made.tags = d.tags;
  return made;
}

function providers(legend) {
  const ask = (method, params) => connection.request(`textDocument/${method}`, params);
  const l = vscode.languages;
  const signature = (found) => {
    const made = new vscode.SignatureHelp();
    made.signatures = found.signatures.map((s) => {
      const one = new vscode.SignatureInformation(s.label, s.documentation);
      one.parameters = s.parameters.map((p) => new vscode.ParameterInformation(p.label));
      return one;
    });
    made.activeParameter = found.activeParameter;
    return made;
  };
  return [
    l.registerHoverProvider(SELECTOR, {
      provideHover: async (d, p) => {
        const found = await ask("hover", at(d, p));
        return found && new vscode.Hover(markdown(found.contents), range(found.range));
      },
    }),
    l.registerDefinitionProvider(SELECTOR, {
      provideDefinition: async (d, p) => (await ask("definition", at(d, p))).map(place),
    }),
    l.registerReferenceProvider(SELECTOR, {
      provideReferences: async (d, p, context) => (await ask("references", { ...at(d, p), context })).map(place),
    }),
    l.registerDocumentHighlightProvider(SELECTOR, {
      provideDocumentHighlights: async (d, p) =>
        (await ask("documentHighlight", at(d, p))).map((h) => new vscode.DocumentHighlight(range(h.range), h.kind - 1)),
    }),
    l.registerRenameProvider(SELECTOR, {
      provideRenameEdits: async (d, p, newName) => workspaceEdit(await ask("rename", { ...at(d, p), newName })),
      prepareRename: async (d, p) => range(await ask("prepareRename", at(d, p))),
    }),
    l.registerCompletionItemProvider(
      SELECTOR,
      { provideCompletionItems: async (d, p) => (await ask("completion", at(d, p))).items.map(completion) },
      ".", "(", "[", ":", " "
    ),
    l.registerSignatureHelpProvider(
      SELECTOR,
      {
        provideSignatureHelp: async (d, p) => {
          const found = await ask("signatureHelp", at(d, p));
          return found && signature(found);
        },
      },
      "(", "[", ",", " "
    ),
    l.registerCodeActionsProvider(SELECTOR, {
      provideCodeActions: async (d, where) =>
        (await ask("codeAction", { ...of(d), range: where, context: { diagnostics: [] } })).map((a) => {
          const made = new vscode.CodeAction(a.title, vscode.CodeActionKind.QuickFix);
          made.edit = workspaceEdit(a.edit);
          made.isPreferred = a.isPreferred;
          return made;
        }),
    }),
    l.registerDocumentSymbolProvider(SELECTOR, {
      provideDocumentSymbols: async (d) => (await ask("documentSymbol", of(d))).map(symbol),
    }),
    l.registerWorkspaceSymbolProvider({
      provideWorkspaceSymbols: async (query) =>
        (await connection.request("workspace/symbol", { query })).map(
          (s) => new vscode.SymbolInformation(s.name, s.kind - 1, s.containerName || "", place(s.location))
        ),
    }),
    l.registerFoldingRangeProvider(SELECTOR, {
      provideFoldingRanges: async (d) =>
        (await ask("foldingRange", of(d))).map((f) => new vscode.FoldingRange(f.startLine, f.endLine)),
    }),
    l.registerCodeLensProvider(SELECTOR, {
      provideCodeLenses: async (d) =>
        (await ask("codeLens", of(d))).map((c) => new vscode.CodeLens(range(c.range), c.command)),
    }),
    l.registerInlayHintsProvider(SELECTOR, {
      provideInlayHints: async (d, where) =>
        (await ask("inlayHint", { ...of(d), range: where })).map((h) => {
          const made = new vscode.InlayHint(new vscode.Position(h.position.line, h.position.character), h.label, h.kind);
          made.paddingLeft = h.paddingLeft;
          made.paddingRight = h.paddingRight;
          return made;
        }),
    }),
    l.registerDocumentFormattingEditProvider(SELECTOR, {
      provideDocumentFormattingEdits: async (d, options) => (await ask("formatting", { ...of(d), options })).map(edit),
    }),
    l.registerDocumentRangeFormattingEditProvider(SELECTOR, {
      provideDocumentRangeFormattingEdits: async (d, where, options) =>
        (await ask("rangeFormatting", { ...of(d), range: where, options })).map(edit),
    }),
    l.registerDocumentSemanticTokensProvider(
      SELECTOR,
      {
        provideDocumentSemanticTokens: async (d) =>
          new vscode.SemanticTokens(new Uint32Array((await ask("semanticTokens/full", of(d))).data)),
      },
      new vscode.SemanticTokensLegend(legend.tokenTypes, legend.tokenModifiers)
    ),
  ];
}

function commands(command) {
  const terminal = (verb) => (uri, task) => {
    const file = uri ? vscode.Uri.parse(uri) : vscode.window.activeTextEditor.document.uri;
    const shown = vscode.window.createTerminal({ name: `tamplang ${verb}`, shellPath: command,
      shellArgs: [verb, file.fsPath, ...(task ? [task] : [])] });
    shown.show();
  };
  return ["solve", "run"].map((verb) => vscode.commands.registerCommand(`tamplang.${verb}`, terminal(verb)));
}

async function activate(context) {
  const command = vscode.workspace.getConfiguration("tamplang").get("command");
  const shown = vscode.languages.createDiagnosticCollection("tamplang");
  context.subscriptions.push(shown, ...commands(command));
  const folders = (vscode.workspace.workspaceFolders || []).map((f) => ({ uri: f.uri.toString(), name: f.name }));
  const cwd = folders.length ? vscode.workspace.workspaceFolders[0].uri.fsPath : undefined;
  connection = new Connection(command, ["lsp"], cwd, (method, params) => {
    if (method === "textDocument/publishDiagnostics") {
      shown.set(vscode.Uri.parse(params.uri), params.diagnostics.map(diagnostic));
    }
  }, (why) => vscode.window.showWarningMessage(`tamplang: ${why}`));
  const answer = await connection.request("initialize", {
    processId: process.pid,
    rootUri: folders.length ? folders[0].uri : null,
    workspaceFolders: folders,
    capabilities: { general: { positionEncodings: ["utf-16"] } },
  });
  connection.notify("initialized", {});
  const isOurs = (d) => d.languageId === "tamplang";
  const open = (d) => isOurs(d) && connection.notify("textDocument/didOpen", {
    textDocument: { uri: d.uri.toString(), languageId: "tamplang", version: d.version, text: d.getText() } });
  vscode.workspace.textDocuments.forEach(open);
  context.subscriptions.push(
    vscode.workspace.onDidOpenTextDocument(open),
    vscode.workspace.onDidChangeTextDocument(({ document: d }) => isOurs(d) &&
      connection.notify("textDocument/didChange", {
        textDocument: { uri: d.uri.toString(), version: d.version }, contentChanges: [{ text: d.getText() }] })),
    vscode.workspace.onDidCloseTextDocument((d) => isOurs(d) && connection.notify("textDocument/didClose", of(d))),
    ...providers(answer.capabilities.semanticTokensProvider.legend)
  );
}

const deactivate = () => connection && connection.close();

module.exports = { activate, deactivate };
