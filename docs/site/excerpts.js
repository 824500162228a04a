// The search makes its excerpts from the pages that it fetches, which a browser does not permit where the site is a folder of
// files. page_texts.js has the text of each, by its name. The search looks in it for the stems of the words, which need not
// be there, and otherwise takes the beginning: it is given the text around the first of the words themselves.
const before = 100;
const words = (new URLSearchParams(window.location.search).get("q") || "").toLowerCase().split(/[^\p{L}\p{N}_]+/u);

window.fetch = async (url) => {
    const name = url.slice(DOCUMENTATION_OPTIONS.URL_ROOT.length, -DOCUMENTATION_OPTIONS.FILE_SUFFIX.length);
    const text = pageTexts[name];
    const places = words.filter((word) => word).map((word) => text.toLowerCase().indexOf(word));
    const first = Math.min(...places.filter((place) => place >= 0));
    const page = document.createElement("div");
    page.setAttribute("role", "main");
    page.textContent = text.slice(Number.isFinite(first) ? Math.max(0, first - before) : 0);
    return { text: async () => page.outerHTML };
};
