// Starts ReDoc; a file of its own, since the page's policy admits no script inside it.
Redoc.init("openapi.json", { disableSearch: false }, document.getElementById("page"));
