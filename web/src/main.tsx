import { render } from "preact";

import { loadLanguage } from "./i18n";
import { App } from "./shell/App";
import "./shell/theme.css";
import "./shell/layout.css";
import "./parts/parts.css";

await loadLanguage();
const page = document.getElementById("page");
if (page) render(<App />, page);
