import { useState } from "preact/hooks";

import { setLanguage, words } from "../i18n";
import { LANGUAGES, type Language, language } from "../i18n/language";
import { Link } from "../parts/Link";
import { ROOMS } from "../rooms";
import { address, place } from "../router";
import icon from "./icon.svg";
import { THEMES, type Theme, theme } from "./theme";

export function Header() {
  const text = words.value.shell;
  const [isLost, setIsLost] = useState(false);
  const speak = (next: Language) => {
    setIsLost(false);
    setLanguage(next).catch(() => setIsLost(true));
  };
  return (
    <header class="top">
      <Link to="/" class="brand">
        <img src={icon} alt="" width={22} height={22} />
        slewtrack
      </Link>
      <nav aria-label={text.menu}>
        <ul>
          {ROOMS.filter((room) => room.inMenu).map((room) => (
            <li key={room.path}>
              <Link to={room.path} current={isIn(room.path)}>
                {text.rooms[room.title]}
              </Link>
            </li>
          ))}
        </ul>
      </nav>
      <div class="settings">
        {isLost && <span role="alert">{text.problem.noAnswer}</span>}
        <a href={address("/docs")}>{text.documentation}</a>
        <select
          aria-label={text.language}
          value={language.value}
          onChange={(event) => {
            speak(event.currentTarget.value as Language);
            event.currentTarget.value = language.peek(); // until its words are there
          }}
        >
          {Object.entries(LANGUAGES).map(([code, name]) => (
            <option key={code} value={code} lang={code}>
              {name}
            </option>
          ))}
        </select>
        <select
          aria-label={text.theme}
          value={theme.value}
          onChange={(event) => {
            theme.value = event.currentTarget.value as Theme;
          }}
        >
          {THEMES.map((one) => (
            <option key={one} value={one}>
              {text.themes[one]}
            </option>
          ))}
        </select>
      </div>
    </header>
  );
}

function isIn(path: string): boolean {
  const now = place.value.path;
  return path === "/" ? now === "/" : now === path || now.startsWith(`${path}/`);
}
