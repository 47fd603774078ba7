"""How machines call time, travel and force in many languages; names only, units are elsewhere.

Words are compared in lower case, without accents, and in one form of full and half width letters.
Latin and Cyrillic words begin a word (`displacement`), German joins them, so its words may end one
(`Standardkraft`); Chinese, Japanese and Korean have no blanks, so theirs stand anywhere.
"""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

_LETTERS = str.maketrans({"ß": "ss", "ł": "l", "ø": "o", "đ": "d", "ı": "i", "æ": "ae", "œ": "oe"})


@lru_cache(maxsize=8192)
def plain(name: str) -> str:
    """A name in lower case, without accents and doubled blanks."""
    lower = unicodedata.normalize("NFKC", name).lower().translate(_LETTERS)
    letters = unicodedata.normalize("NFKD", lower)
    return " ".join("".join(c for c in letters if not unicodedata.combining(c)).split())


def _pattern(begin: str, end: str = "", anywhere: str = "") -> str:
    """One regular expression of words that begin a word, end one, or stand anywhere."""
    parts = [rf"(?<![^\W_])(?:{'|'.join(map(re.escape, plain(begin).split()))})"] if begin else []
    parts += [rf"{re.escape(word)}(?![^\W_])" for word in plain(end).split()]
    parts += [re.escape(word) for word in plain(anywhere).split()]
    return "|".join(parts)


TIME = _pattern(
    "elapsed running tempo tiempo temps czas cas_ время χρονος",
    "time zeit tijd czas duree tid aika zaman cas tempo idő",
    "時間 时间 経過 시간",
)
TRAVEL = _pattern(
    "standard extension displacement elongation travel stroke position slip course distance disp "
    "deplacement allongement desplazamiento alargamiento elongacion posicion recorrido carrera "
    "spostamento corsa allungamento estensione posizione deslocamento alongamento curso extensao "
    "posicao kolben verplaatsing verlenging uitrekking afstand przemieszczenie wydluzenie droga "
    "skok posunuti prodlouzeni draha posuv forlangning forskjutning forskydning forlaengelse "
    "siirtyma uzama deplasman elmozdulas nyulas actuator deflection separation ram "
    "перемещение удлинение ход смещение μετατοπιση επιμηκυνση",
    "weg verschiebung verlangerung extension displacement travel hub",
    "変位 ストローク 伸び 移動 位移 行程 伸长 伸長 변위 신장 스트로크",
)
CROSSHEAD = _pattern(
    "crosshead cross-head travers trawers dwarsjuk pricnik траверс",
    "traverse",
    "クロスヘッド 横梁 橫梁 크로스헤드",
)
SENSOR = (
    _pattern(
        "extensomet ekstensomet capteur strain deformation deformaci deformazione deformacao laser "
        "video local lvdt tool true correct korrig corrig nominal rek odksztalc отн деформаци "
        "tensometr экстензометр axial_strain dehnung",
        "aufnehmer dehnung extensometer",
        "歪 ひずみ 伸び計 变形 變形 应变 應變 引伸计",
    )
    + r"|feindehn|\bave\d*\b"
)
NOT_TRAVEL = (
    _pattern(
        "width thickness diameter breite dicke largeur epaisseur anchura espesor larghezza "
        "spessore largura espessura breedte dikte szerokosc grubosc ширина толщина initial "
        "rms amplitude error fehler command demand soll setpoint target peak-to-peak",
        "",
        "幅 厚さ 厚み 宽度 厚度 直径",
    )
    + r"|\bgau?ge length|\b[lL]0\b|\bl0\b|\b(at|bei) (max|peak|break|fmax)"
)
FORCE = (
    _pattern(
        "force load charge effort fuerza carga forza carico forca kracht belasting sila obciazenie "
        "zatizeni zatezna voima kuvvet yuk ero_ сила нагрузка усилие δυναμη φορτιο",
        "kraft kracht force load last",
        "荷重 試験力 ロード 负荷 负载 载荷 負荷 試驗力 试验力 拉力 하중 힘",
    )
    + "|力"
)
OTHER_FORCE = r"\d|\b(peak|max|min|mean|filter|raw|true|error|command|demand|soll|aux|normal)"
ELSE = _pattern(
    "torque moment rotation angle winkel couple stress contrainte tension_ esfuerzo sforzo tensao "
    "naprezenie napeti spanning напряжение rate speed velocity geschwindigkeit vitesse velocidad "
    "velocita predkosc скорость temperature temperatur energy energie work pressure druck",
    "spannung geschwindigkeit",
    "応力 应力 應力 速度 温度 응력 トルク",
)
SPECIMEN = _pattern(
    "specimen sample probe prufkorper eprouvette echantillon probeta muestra provino campione "
    "provete amostra corpo proefstuk monster probka vzorek prov образец test run versuch essai "
    "ensayo prova ensaio cycle",
    "probe",
    "試験片 试样 試樣 試料 样品 시편",
)
STATISTIC = _pattern(
    "mean average avg max min std stdev sd standard median range cov count sum mittelwert mittel "
    "maximum minimum standardabw moyenne ecart media desviacion deviazione gemiddelde srednia "
    "odchylenie prumer среднее макс мин end ende fin fine fim",
    "",
    "平均 最大 最小 標準 标准",
)
UNIT = _pattern(
    "unit units einheit unite unidad unita unidade eenheid jednostka jednotka enhet единиц",
    "einheit unit units",
    "単位 单位 單位 단위",
)
ROLE = {"time": TIME, "elongation": f"{TRAVEL}|{CROSSHEAD}", "force": FORCE}
_ANY = re.compile("|".join([*ROLE.values(), SENSOR, SPECIMEN, UNIT, ELSE]))


def known_words(text: str) -> int:
    """How many characters of a text belong to words of machines; tells code pages apart."""
    return sum(len(m[0]) for m in _ANY.finditer(plain(text)) if not m[0].isascii()) * 4 + sum(
        len(m[0]) for m in _ANY.finditer(plain(text)) if m[0].isascii()
    )
