// Renders every formula by KaTeX. A formula that KaTeX rejects is an error in the console, which the tests of the site find.
document.addEventListener("DOMContentLoaded", () => {
  for (const element of document.querySelectorAll(".arithmatex")) {
    const tex = element.textContent.trim();
    const display = tex.startsWith("\\[");
    try {
      katex.render(tex.replace(/^\\[[(]|\\[\])]$/g, ""), element, { displayMode: display, throwOnError: true });
    } catch (error) {
      console.error(`${error.message}: ${tex}`);
    }
  }
});
